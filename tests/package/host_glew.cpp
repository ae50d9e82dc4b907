// A host whose loader is GLEW, whose header refuses to stand after another loader's.
#include <GL/glew.h>

#include "egl_context.h"
#include "picture.h"

int main()
{
    if (!make_egl_context())
        return 77;
    glewExperimental = GL_TRUE;
    const GLenum made = glewInit();
    // Without an X display GLEW has loaded OpenGL and says that GLX is missing.
    if (made != GLEW_OK && made != GLEW_ERROR_NO_GLX_DISPLAY)
        return 1;
    return draw_ball(eglGetProcAddress, "GLEW, shared library, core alone");
}
