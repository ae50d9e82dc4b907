#pragma once

#include <glad/gl.h>

#include <fumarole/settings.h>

namespace fumarole::pass {

/// A layer's format as the GL names it.
inline GLenum gl_format(Settings::Format format)
{
    switch (format) {
    case Settings::Format::r11g11b10f:
        return GL_R11F_G11F_B10F;
    case Settings::Format::rgba16f:
        return GL_RGBA16F;
    default:
        return GL_RGBA32F;
    }
}

}  // namespace fumarole::pass
