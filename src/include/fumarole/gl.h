#pragma once

#include <cstdint>
#include <glm/glm.hpp>

// What a host and the library say to each other of OpenGL, without any loader's header.

namespace fumarole::gl {

/// Finds GL functions by name: OSMesaGetProcAddress, eglGetProcAddress, glfwGetProcAddress, ...
using GetProc = void (*(*)(const char* name))();

/// A texture that somebody else owns.
struct TextureView {
    std::uint32_t id = 0;  ///< the GL's name of it
    glm::ivec3 size{0};    ///< texels; z is depth, or layers of an array

    explicit operator bool() const { return id != 0; }
};

}  // namespace fumarole::gl
