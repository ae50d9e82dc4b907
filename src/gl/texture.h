#pragma once

#include <glm/glm.hpp>
#include <string_view>
#include <vector>

#include <fumarole/gl.h>

#include "gl/device.h"

namespace fumarole::gl {

/// Binds a texture to a unit, and none where the view is empty: glBindTextureUnit of name 0 would
/// take away what the host has bound to every other target of the unit, while that of a texture
/// changes the target of its kind alone, which StateGuard puts back. Passes bind with this only.
inline void bind_texture(const Device& gl, GLuint unit, TextureView texture)
{
    if (!texture)
        return;
    gl.take_texture_unit(unit);
    gl->BindTextureUnit(unit, texture.id);
}

enum class Filter { nearest, linear, depth_compare };

/// Immutable storage, one level, clamped to its edge, made and filled without being bound.
class Texture {
public:
    Texture() = default;
    static Texture make_2d(const Device& device, std::string_view label, glm::ivec2 size,
                           GLenum format, Filter filter);
    static Texture make_2d_array(const Device& device, std::string_view label, glm::ivec3 size,
                                 GLenum format, Filter filter);
    /// @throws Error if the GL has no memory for it.
    static Texture make_3d(const Device& device, std::string_view label, glm::ivec3 size,
                           GLenum format, Filter filter);

    /// All texels, x fastest, tightly packed; `format` and `type` describe `data`.
    void upload(GLenum format, GLenum type, const void* data);
    /// The same for what is large, by way of a buffer that the GPU reads when it comes to it. GL
    /// has to copy what lies in our memory before upload() returns, and waits where its own place
    /// for that is full; here it copies while it does what was asked before.
    /// @param bytes of all texels
    void stage(GLenum format, GLenum type, const void* data, std::size_t bytes);
    /// The same in parts: as many rows from `first` on, counted through all slices, as `most` bytes
    /// are, but one at least and none that a box has no place for: whole slices, or rows of one.
    /// @param data all texels, of which a row has `row_bytes` @returns how many rows
    std::size_t stage_rows(GLenum format, GLenum type, const std::uint8_t* data,
                           std::size_t row_bytes, std::size_t first, std::size_t most);
    /// Of all slices.
    [[nodiscard]] std::size_t rows() const
    {
        return static_cast<std::size_t>(size_.y) * static_cast<std::size_t>(size_.z);
    }

    /// Sets all texels to one; `format` and `type` describe it.
    void clear(GLenum format, GLenum type, const void* texel) const
    {
        handle_.device()->ClearTexImage(id(), 0, format, type, texel);
    }

    /// All texels as floats, `channels` of each (1, 3 or 4), first row first.
    [[nodiscard]] std::vector<float> read(int channels) const;

    [[nodiscard]] TextureView view() const { return {handle_.id(), size_}; }
    [[nodiscard]] GLuint id() const { return handle_.id(); }
    [[nodiscard]] glm::ivec3 size() const { return size_; }
    explicit operator bool() const { return static_cast<bool>(handle_); }

    /// Binds all of it as an image. An empty texture leaves the unit as it is.
    void bind_image(GLuint unit, GLenum access) const;

    /// As bind_texture(): an empty texture leaves the unit as it is.
    void bind(GLuint unit) const
    {
        if (handle_)
            bind_texture(handle_.device(), unit, view());
    }

private:
    static void destroy(const Device& device, GLuint id);
    static Texture make(const Device& device, std::string_view label, GLenum target,
                        glm::ivec3 size, GLenum format, Filter filter);
    /// Texels of a box: all of its rows are whole.
    struct Box {
        int y = 0, z = 0, rows = 0, slices = 0;
    };
    void write(GLenum format, GLenum type, const void* data, Box box);
    void stage_box(GLenum format, GLenum type, const void* data, std::size_t bytes, Box box);

    Handle<&Texture::destroy> handle_;
    GLenum target_ = 0, format_ = 0;
    glm::ivec3 size_{0};
};

/// Fetches texels as they are, whatever the parameters of the texture that it is bound with.
class Sampler {
public:
    Sampler() = default;
    Sampler(const Device& device, std::string_view label);
    [[nodiscard]] GLuint id() const { return handle_.id(); }

private:
    static void destroy(const Device& gl, GLuint id) { gl->DeleteSamplers(1, &id); }
    Handle<&Sampler::destroy> handle_;
};

/// floats of a colour or depth texture that we may not own, as Texture::read.
std::vector<float> read_texture(const Device& device, TextureView texture, int channels,
                                bool depth = false);

}  // namespace fumarole::gl
