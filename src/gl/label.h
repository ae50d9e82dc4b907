#pragma once

#include <string_view>

#include "gl/device.h"

namespace fumarole::gl {

/// Names an object for captures and debug messages.
inline void set_label(const Device& gl, GLenum kind, GLuint id, std::string_view label)
{
    gl->ObjectLabel(kind, id, static_cast<GLsizei>(label.size()), label.data());
}

}  // namespace fumarole::gl
