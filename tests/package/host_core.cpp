// A host that links the static core alone and feeds it densities of its own.
#include <glad/gl.h>

#include "osmesa_context.h"
#include "picture.h"

int main()
{
    if (!make_osmesa_context() || gladLoadGL(OSMesaGetProcAddress) == 0)
        return 1;
    return draw_ball(OSMesaGetProcAddress, "own glad, static library, core alone");
}
