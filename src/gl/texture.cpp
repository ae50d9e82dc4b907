#include "gl/texture.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>
#include <fmt/format.h>

#include "gl/label.h"
#include "gl/transfer.h"
#include <fumarole/errors.h>

namespace fumarole::gl {

namespace {

std::int64_t texel_bytes(GLenum format)
{
    switch (format) {
    case GL_R8:
    case GL_R8UI:
        return 1;
    case GL_R16F:
    case GL_DEPTH_COMPONENT16:
    case GL_R16UI:
    case GL_R16:
        return 2;
    case GL_R32F:
    case GL_R32UI:
    case GL_RG16F:
    case GL_R11F_G11F_B10F:
    case GL_RGBA8:
    case GL_RGB10_A2:
    case GL_SRGB8_ALPHA8:
    case GL_DEPTH_COMPONENT24:
    case GL_DEPTH_COMPONENT32F:
        return 4;
    case GL_RG32F:
    case GL_RG32UI:
    case GL_RGBA16:
    case GL_RGBA16F:
        return 8;
    case GL_RGBA32F:
    case GL_RGBA32UI:
        return 16;
    default:
        assert(false && "a format whose bytes are not known");
        return 0;
    }
}

/// Bytes of a texture, asked of the GL so that destroying needs no state of ours.
std::int64_t texture_bytes(const Device& gl, GLuint id)
{
    GLint width = 0, height = 0, depth = 0, format = 0;
    gl->GetTextureLevelParameteriv(id, 0, GL_TEXTURE_WIDTH, &width);
    gl->GetTextureLevelParameteriv(id, 0, GL_TEXTURE_HEIGHT, &height);
    gl->GetTextureLevelParameteriv(id, 0, GL_TEXTURE_DEPTH, &depth);
    gl->GetTextureLevelParameteriv(id, 0, GL_TEXTURE_INTERNAL_FORMAT, &format);
    return std::int64_t{width} * height * depth * texel_bytes(static_cast<GLenum>(format));
}

}  // namespace

void Texture::destroy(const Device& gl, GLuint id)
{
    gl.account(-texture_bytes(gl, id));
    gl->DeleteTextures(1, &id);
}

Texture Texture::make(const Device& gl, std::string_view label, GLenum target, glm::ivec3 size,
                      GLenum format, Filter filter)
{
    assert(size.x > 0 && size.y > 0 && size.z > 0);
    GLuint id = 0;
    gl->CreateTextures(target, 1, &id);
    Texture texture;
    texture.handle_ = {gl, id};
    texture.target_ = target;
    texture.format_ = format;
    texture.size_ = size;
    set_label(gl, GL_TEXTURE, id, label);
    if (target == GL_TEXTURE_2D)
        gl->TextureStorage2D(id, 1, format, size.x, size.y);
    else
        gl->TextureStorage3D(id, 1, format, size.x, size.y, size.z);
    GLint made = GL_FALSE;
    gl->GetTextureParameteriv(id, GL_TEXTURE_IMMUTABLE_FORMAT, &made);
    if (made != GL_TRUE) {
        while (gl->GetError() != GL_NO_ERROR) {  // ours, not to be left to the host
        }
        throw Error(
            fmt::format("OpenGL: no memory for '{}', {} x {} x {} texels of {} bytes; try a "
                        "coarser grid, a smaller picture, a smaller SceneSettings::shadow_map or "
                        "SceneSettings::shadow_volume_size, or fewer froxels (FrameSettings::tile, "
                        "FrameSettings::slices)",
                        label, size.x, size.y, size.z, texel_bytes(format)));
    }
    gl.account(texture_bytes(gl, id));

    const bool smooth = filter != Filter::nearest;
    gl->TextureParameteri(id, GL_TEXTURE_MIN_FILTER, smooth ? GL_LINEAR : GL_NEAREST);
    gl->TextureParameteri(id, GL_TEXTURE_MAG_FILTER, smooth ? GL_LINEAR : GL_NEAREST);
    for (GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R})
        gl->TextureParameteri(id, wrap, GL_CLAMP_TO_EDGE);
    if (filter == Filter::depth_compare) {
        gl->TextureParameteri(id, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
        gl->TextureParameteri(id, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
    }
    return texture;
}

Texture Texture::make_2d(const Device& gl, std::string_view label, glm::ivec2 size, GLenum format,
                         Filter filter)
{
    return make(gl, label, GL_TEXTURE_2D, glm::ivec3(size, 1), format, filter);
}

Texture Texture::make_2d_array(const Device& gl, std::string_view label, glm::ivec3 size,
                               GLenum format, Filter filter)
{
    return make(gl, label, GL_TEXTURE_2D_ARRAY, size, format, filter);
}

Texture Texture::make_3d(const Device& gl, std::string_view label, glm::ivec3 size, GLenum format,
                         Filter filter)
{
    return make(gl, label, GL_TEXTURE_3D, size, format, filter);
}

void Texture::upload(GLenum format, GLenum type, const void* data)
{
    const TightTransfer tight(handle_.device(), TightTransfer::Direction::unpack);
    write(format, type, data, {0, 0, size_.y, size_.z});
}

void Texture::stage(GLenum format, GLenum type, const void* data, std::size_t bytes)
{
    stage_box(format, type, data, bytes, {0, 0, size_.y, size_.z});
}

std::size_t Texture::stage_rows(GLenum format, GLenum type, const std::uint8_t* data,
                                std::size_t row_bytes, std::size_t first, std::size_t most)
{
    const auto of_slice = static_cast<std::size_t>(size_.y);
    const std::size_t fit = std::max<std::size_t>(most / row_bytes, 1);
    const std::size_t y = first % of_slice, left = rows() - first;
    const bool whole = y == 0 && fit >= of_slice;
    const std::size_t now =
        whole ? std::min(fit, left) / of_slice * of_slice : std::min(fit, of_slice - y);
    const Box box{static_cast<int>(y), static_cast<int>(first / of_slice),
                  static_cast<int>(whole ? of_slice : now),
                  static_cast<int>(whole ? now / of_slice : 1)};
    stage_box(format, type, data + first * row_bytes, now * row_bytes, box);
    return now;
}

void Texture::stage_box(GLenum format, GLenum type, const void* data, std::size_t bytes, Box box)
{
    const Device& gl = handle_.device();
    GLuint buffer = 0;
    gl->CreateBuffers(1, &buffer);
    set_label(gl, GL_BUFFER, buffer, "staged texels");
    gl->NamedBufferStorage(buffer, static_cast<GLsizeiptr>(bytes), nullptr,
                           GL_MAP_WRITE_BIT | GL_CLIENT_STORAGE_BIT);
    // Nothing has used the buffer yet, so there is nothing to wait for.
    void* mapped = gl->MapNamedBufferRange(buffer, 0, static_cast<GLsizeiptr>(bytes),
                                           GL_MAP_WRITE_BIT | GL_MAP_UNSYNCHRONIZED_BIT |
                                               GL_MAP_INVALIDATE_BUFFER_BIT);
    if (mapped == nullptr) {  // no memory for a second copy of it
        gl->DeleteBuffers(1, &buffer);
        while (gl->GetError() != GL_NO_ERROR) {  // ours, not to be left to the host
        }
        const TightTransfer tight(gl, TightTransfer::Direction::unpack);
        write(format, type, data, box);
        return;
    }
    std::memcpy(mapped, data, bytes);
    gl->UnmapNamedBuffer(buffer);
    {
        const TightTransfer tight(gl, TightTransfer::Direction::unpack, buffer);
        write(format, type, nullptr, box);
    }
    gl->DeleteBuffers(1, &buffer);  // GL keeps what is in it until it is copied
}

void Texture::write(GLenum format, GLenum type, const void* data, Box box)
{
    const Device& gl = handle_.device();
    if (target_ == GL_TEXTURE_2D)
        gl->TextureSubImage2D(id(), 0, 0, box.y, size_.x, box.rows, format, type, data);
    else
        gl->TextureSubImage3D(id(), 0, 0, box.y, box.z, size_.x, box.rows, box.slices, format, type,
                              data);
}

void Texture::bind_image(GLuint unit, GLenum access) const
{
    const GLboolean layered = target_ == GL_TEXTURE_2D ? GL_FALSE : GL_TRUE;
    if (handle_)
        handle_.device()->BindImageTexture(unit, id(), 0, layered, 0, access, format_);
}

Sampler::Sampler(const Device& gl, std::string_view label)
{
    GLuint id = 0;
    gl->CreateSamplers(1, &id);
    handle_ = {gl, id};
    set_label(gl, GL_SAMPLER, id, label);
    gl->SamplerParameteri(id, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl->SamplerParameteri(id, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl->SamplerParameteri(id, GL_TEXTURE_COMPARE_MODE, GL_NONE);
}

std::vector<float> Texture::read(int channels) const
{
    return read_texture(handle_.device(), view(), channels);
}

std::vector<float> read_texture(const Device& gl, TextureView texture, int channels, bool depth)
{
    const GLenum format = depth           ? GL_DEPTH_COMPONENT
                          : channels == 1 ? GL_RED
                          : channels == 3 ? GL_RGB
                                          : GL_RGBA;
    std::vector<float> texels(static_cast<std::size_t>(texture.size.x) * texture.size.y *
                              texture.size.z * channels);
    const TightTransfer tight(gl, TightTransfer::Direction::pack);
    gl->GetTextureImage(texture.id, 0, format, GL_FLOAT,
                        static_cast<GLsizei>(texels.size() * sizeof(float)), texels.data());
    return texels;
}

}  // namespace fumarole::gl
