#pragma once

#include <optional>

#include <fumarole/gl.h>

#include "gl/device.h"

namespace fumarole::gl {

/// A texture's format as shaders that load from it have to name it.
struct ImageFormat {
    GLenum format = 0;        ///< GL_RGBA16F
    const char* name = "";    ///< name in a layout qualifier: rgba16f
    bool normalized = false;  ///< integers that stand for 0..1, to which blending clamps
};

/// Of a picture's colour, whoever made it; nothing if shaders can't load and store its texels: its
/// format is none that images may have (GL_SRGB8_ALPHA8), or levels are missing that its filter
/// asks for.
std::optional<ImageFormat> image_format(const Device& device, TextureView texture);

/// Whether look-ups decode its texels, which blending takes as they are (StateGuard).
bool decodes_srgb(const Device& device, TextureView texture);

}  // namespace fumarole::gl
