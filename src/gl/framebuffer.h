#pragma once

#include <initializer_list>
#include <string_view>

#include "gl/device.h"
#include "gl/texture.h"

namespace fumarole::gl {

/// Where a pass draws. Holds attachments, not textures.
class Framebuffer {
public:
    Framebuffer() = default;
    Framebuffer(const Device& device, std::string_view label);

    /// Sets the colour attachments, in order. @throws Error if the GL can't draw to them.
    void attach_color(std::initializer_list<TextureView> colors);
    /// Takes the colour away again, as textures of a host's are to be let go of.
    void detach_color();
    /// Sets the one colour attachment.
    void attach_color_layer(TextureView color, int layer);
    void attach_depth(TextureView depth);
    void attach_depth_layer(TextureView depth, int layer);

    /// Draws to nothing: fragments that write images alone.
    void set_empty(glm::ivec2 size) const;

    /// Copies the first colour of another framebuffer, from `low` to before `high`, into this
    /// one's.
    void copy_color_of(const Framebuffer& from, glm::ivec2 low, glm::ivec2 high) const;

    /// Binds for drawing, with a viewport that covers `size`.
    void bind(glm::ivec2 size) const;
    [[nodiscard]] GLuint id() const { return handle_.id(); }
    explicit operator bool() const { return static_cast<bool>(handle_); }

private:
    static void destroy(const Device& gl, GLuint id) { gl->DeleteFramebuffers(1, &id); }
    Handle<&Framebuffer::destroy> handle_;
};

/// An empty or an indexed vertex array.
class VertexArray {
public:
    VertexArray() = default;
    VertexArray(const Device& device, std::string_view label);
    [[nodiscard]] GLuint id() const { return handle_.id(); }
    explicit operator bool() const { return static_cast<bool>(handle_); }

private:
    static void destroy(const Device& gl, GLuint id) { gl->DeleteVertexArrays(1, &id); }
    Handle<&VertexArray::destroy> handle_;
};

}  // namespace fumarole::gl
