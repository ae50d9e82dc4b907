#include "gl/image_format.h"

#include <algorithm>
#include <array>

namespace fumarole::gl {

namespace {

// Of the GL's formats of images those that a picture may have: all channels, of one kind.
constexpr std::array kFormats{ImageFormat{GL_RGBA16F, "rgba16f", false},
                              ImageFormat{GL_RGBA32F, "rgba32f", false},
                              ImageFormat{GL_R11F_G11F_B10F, "r11f_g11f_b10f", false},
                              ImageFormat{GL_RGBA8, "rgba8", true},
                              ImageFormat{GL_RGBA16, "rgba16", true},
                              ImageFormat{GL_RGB10_A2, "rgb10_a2", true}};

GLenum internal_format(const Device& gl, TextureView texture)
{
    GLint format = 0;
    gl->GetTextureLevelParameteriv(texture.id, 0, GL_TEXTURE_INTERNAL_FORMAT, &format);
    return static_cast<GLenum>(format);
}

/// A host's texture of one level that was not made by glTexStorage is no image unless it is
/// complete, and by default its filter asks for all levels.
bool is_complete(const Device& gl, TextureView texture)
{
    GLint immutable = GL_FALSE, filter = 0;
    gl->GetTextureParameteriv(texture.id, GL_TEXTURE_IMMUTABLE_FORMAT, &immutable);
    gl->GetTextureParameteriv(texture.id, GL_TEXTURE_MIN_FILTER, &filter);
    return immutable == GL_TRUE || filter == GL_NEAREST || filter == GL_LINEAR;
}

}  // namespace

std::optional<ImageFormat> image_format(const Device& gl, TextureView texture)
{
    const GLenum format = internal_format(gl, texture);
    const auto found = std::find_if(kFormats.begin(), kFormats.end(),
                                    [&](const ImageFormat& one) { return one.format == format; });
    if (found == kFormats.end() || !is_complete(gl, texture))
        return std::nullopt;
    return *found;
}

bool decodes_srgb(const Device& gl, TextureView texture)
{
    const GLenum format = internal_format(gl, texture);
    return format == GL_SRGB8_ALPHA8 || format == GL_SRGB8;
}

}  // namespace fumarole::gl
