#include "gl/framebuffer.h"

#include <array>
#include <fmt/format.h>

#include "gl/label.h"
#include <fumarole/errors.h>

namespace fumarole::gl {

Framebuffer::Framebuffer(const Device& gl, std::string_view label)
{
    GLuint id = 0;
    gl->CreateFramebuffers(1, &id);
    handle_ = {gl, id};
    set_label(gl, GL_FRAMEBUFFER, id, label);
    gl->NamedFramebufferDrawBuffer(id, GL_NONE);
    gl->NamedFramebufferReadBuffer(id, GL_NONE);
}

void Framebuffer::attach_color(std::initializer_list<TextureView> colors)
{
    const Device& gl = handle_.device();
    std::array<GLenum, 4> buffers{};
    GLsizei count = 0;
    for (const TextureView& color : colors) {
        const GLenum slot = GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(count);
        gl->NamedFramebufferTexture(id(), slot, color.id, 0);
        buffers.at(static_cast<std::size_t>(count++)) = slot;
    }
    gl->NamedFramebufferDrawBuffers(id(), count, buffers.data());
    const GLenum status = gl->CheckNamedFramebufferStatus(id(), GL_DRAW_FRAMEBUFFER);
    if (status != GL_FRAMEBUFFER_COMPLETE)
        throw Error(fmt::format("OpenGL: can't draw to the colour texture given (framebuffer "
                                "status {:#06x}); give one of a colour-renderable format, e.g. "
                                "GL_RGBA16F",
                                status));
}

void Framebuffer::attach_color_layer(TextureView color, int layer)
{
    const Device& gl = handle_.device();
    gl->NamedFramebufferTextureLayer(id(), GL_COLOR_ATTACHMENT0, color.id, 0, layer);
    gl->NamedFramebufferDrawBuffer(id(), GL_COLOR_ATTACHMENT0);
}

void Framebuffer::detach_color()
{
    handle_.device()->NamedFramebufferTexture(id(), GL_COLOR_ATTACHMENT0, 0, 0);
}

void Framebuffer::attach_depth(TextureView depth)
{
    handle_.device()->NamedFramebufferTexture(id(), GL_DEPTH_ATTACHMENT, depth.id, 0);
}

void Framebuffer::attach_depth_layer(TextureView depth, int layer)
{
    handle_.device()->NamedFramebufferTextureLayer(id(), GL_DEPTH_ATTACHMENT, depth.id, 0, layer);
}

void Framebuffer::copy_color_of(const Framebuffer& from, glm::ivec2 low, glm::ivec2 high) const
{
    const Device& gl = handle_.device();
    gl->NamedFramebufferReadBuffer(from.id(), GL_COLOR_ATTACHMENT0);
    gl->BlitNamedFramebuffer(from.id(), id(), low.x, low.y, high.x, high.y, low.x, low.y, high.x,
                             high.y, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    gl->NamedFramebufferReadBuffer(from.id(), GL_NONE);
}

void Framebuffer::set_empty(glm::ivec2 size) const
{
    const Device& gl = handle_.device();
    gl->NamedFramebufferParameteri(id(), GL_FRAMEBUFFER_DEFAULT_WIDTH, size.x);
    gl->NamedFramebufferParameteri(id(), GL_FRAMEBUFFER_DEFAULT_HEIGHT, size.y);
}

void Framebuffer::bind(glm::ivec2 size) const
{
    const Device& gl = handle_.device();
    gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, id());
    gl->ViewportIndexedf(0, 0, 0, static_cast<GLfloat>(size.x), static_cast<GLfloat>(size.y));
}

VertexArray::VertexArray(const Device& gl, std::string_view label)
{
    GLuint id = 0;
    gl->CreateVertexArrays(1, &id);
    handle_ = {gl, id};
    set_label(gl, GL_VERTEX_ARRAY, id, label);
}

}  // namespace fumarole::gl
