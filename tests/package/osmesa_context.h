#pragma once

// After the host's loader, which GL/osmesa.h would otherwise bring another GL header beside.
#include <GL/osmesa.h>

/// Makes an OpenGL 4.5 core context of Mesa's software rasteriser current.
inline bool make_osmesa_context()
{
    const int attributes[] = {OSMESA_FORMAT,
                              OSMESA_RGBA,
                              OSMESA_PROFILE,
                              OSMESA_CORE_PROFILE,
                              OSMESA_CONTEXT_MAJOR_VERSION,
                              4,
                              OSMESA_CONTEXT_MINOR_VERSION,
                              5,
                              0};
    static unsigned char pixel[4];
    OSMesaContext context = OSMesaCreateContextAttribs(attributes, nullptr);
    return context != nullptr &&
           OSMesaMakeCurrent(context, pixel, GL_UNSIGNED_BYTE, 1, 1) == GL_TRUE;
}
