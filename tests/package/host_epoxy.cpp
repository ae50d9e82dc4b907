// A host whose loader is libepoxy.
#include <epoxy/gl.h>

#include <epoxy/egl.h>

#include "egl_context.h"
#include "picture.h"

int main()
{
    if (!make_egl_context())
        return 77;
    return draw_ball(eglGetProcAddress, "libepoxy, shared library, core alone");
}
