#include "gl/binding_guard.h"

#include <fmt/format.h>

#include <fumarole/errors.h>

namespace fumarole::gl {

namespace {

void check_point(const Device& gl, GLenum limit, std::uint32_t point, const char* kind)
{
    GLint count = 0;
    gl->GetIntegerv(limit, &count);
    if (point >= static_cast<std::uint32_t>(count))
        throw Error(fmt::format("TransparentBindings: {} {} is none of the {} that this GL has; "
                                "take a smaller number",
                                kind, point, count));
}

}  // namespace

BindingGuard::BindingGuard(const Device& device, const Points& points)
    : gl_{device}, points_{points}, storages_(points.storages.size())
{
    check_point(device, GL_MAX_UNIFORM_BUFFER_BINDINGS, points.block, "uniform block");
    check_point(device, GL_MAX_COMBINED_TEXTURE_IMAGE_UNITS, points.texture_unit, "texture unit");
    check_point(device, GL_MAX_IMAGE_UNITS, points.image, "image unit");
    for (const std::uint32_t storage : points.storages)
        check_point(device, GL_MAX_SHADER_STORAGE_BUFFER_BINDINGS, storage, "storage buffer");

    gl_->GetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &draw_framebuffer_);
    gl_->GetFloati_v(GL_VIEWPORT, 0, viewport_.data());
    gl_->GetIntegerv(GL_UNIFORM_BUFFER_BINDING, &uniform_buffer_);
    gl_->GetIntegerv(GL_SHADER_STORAGE_BUFFER_BINDING, &storage_buffer_);
    const auto note = [&](GLenum binding, GLenum start, GLenum size, std::uint32_t point) {
        Block block;
        gl_->GetIntegeri_v(binding, point, &block.buffer);
        gl_->GetInteger64i_v(start, point, &block.offset);
        gl_->GetInteger64i_v(size, point, &block.size);
        return block;
    };
    block_ = note(GL_UNIFORM_BUFFER_BINDING, GL_UNIFORM_BUFFER_START, GL_UNIFORM_BUFFER_SIZE,
                  points.block);
    for (std::size_t i = 0; i < storages_.size(); ++i)
        storages_[i] = note(GL_SHADER_STORAGE_BUFFER_BINDING, GL_SHADER_STORAGE_BUFFER_START,
                            GL_SHADER_STORAGE_BUFFER_SIZE, points.storages[i]);
    GLint active = 0;
    gl_->GetIntegerv(GL_ACTIVE_TEXTURE, &active);
    gl_->ActiveTexture(GL_TEXTURE0 + points.texture_unit);
    gl_->GetIntegerv(GL_TEXTURE_BINDING_2D, &texture_);
    gl_->GetIntegerv(GL_SAMPLER_BINDING, &sampler_);
    gl_->ActiveTexture(static_cast<GLenum>(active));
    gl_->GetIntegeri_v(GL_IMAGE_BINDING_NAME, points.image, &image_);
    gl_->GetIntegeri_v(GL_IMAGE_BINDING_LEVEL, points.image, &level_);
    gl_->GetBooleani_v(GL_IMAGE_BINDING_LAYERED, points.image, &layered_);
    gl_->GetIntegeri_v(GL_IMAGE_BINDING_LAYER, points.image, &layer_);
    gl_->GetIntegeri_v(GL_IMAGE_BINDING_ACCESS, points.image, &access_);
    gl_->GetIntegeri_v(GL_IMAGE_BINDING_FORMAT, points.image, &format_);
}

void BindingGuard::put_back(GLenum target, std::uint32_t point, const Block& block) const
{
    const auto buffer = static_cast<GLuint>(block.buffer);
    if (block.size > 0)
        gl_->BindBufferRange(target, point, buffer, static_cast<GLintptr>(block.offset),
                             static_cast<GLsizeiptr>(block.size));
    else
        gl_->BindBufferBase(target, point, buffer);
}

BindingGuard::~BindingGuard()
{
    gl_->BindImageTexture(points_.image, static_cast<GLuint>(image_), level_, layered_, layer_,
                          static_cast<GLenum>(access_), static_cast<GLenum>(format_));
    put_back(GL_UNIFORM_BUFFER, points_.block, block_);
    gl_->BindBuffer(GL_UNIFORM_BUFFER, static_cast<GLuint>(uniform_buffer_));
    for (std::size_t i = 0; i < storages_.size(); ++i)
        put_back(GL_SHADER_STORAGE_BUFFER, points_.storages[i], storages_[i]);
    gl_->BindBuffer(GL_SHADER_STORAGE_BUFFER, static_cast<GLuint>(storage_buffer_));
    GLint active = 0;
    gl_->GetIntegerv(GL_ACTIVE_TEXTURE, &active);
    gl_->ActiveTexture(GL_TEXTURE0 + points_.texture_unit);
    gl_->BindTexture(GL_TEXTURE_2D, static_cast<GLuint>(texture_));
    gl_->ActiveTexture(static_cast<GLenum>(active));
    gl_->BindSampler(points_.texture_unit, static_cast<GLuint>(sampler_));
    gl_->ViewportIndexedf(0, viewport_[0], viewport_[1], viewport_[2], viewport_[3]);
    gl_->BindFramebuffer(GL_DRAW_FRAMEBUFFER, static_cast<GLuint>(draw_framebuffer_));
}

}  // namespace fumarole::gl
