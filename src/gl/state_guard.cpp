#include "gl/state_guard.h"

#include <cassert>

namespace fumarole::gl {

namespace {

/// Everything that would spoil a full-screen pass if the host had left it on.
constexpr std::array kSwitches{GL_DEPTH_TEST,          GL_STENCIL_TEST,
                               GL_CULL_FACE,           GL_COLOR_LOGIC_OP,
                               GL_RASTERIZER_DISCARD,  GL_POLYGON_OFFSET_FILL,
                               GL_POLYGON_OFFSET_LINE, GL_POLYGON_OFFSET_POINT,
                               GL_POLYGON_SMOOTH,      GL_LINE_SMOOTH,
                               GL_DEPTH_CLAMP,         GL_DITHER,
                               GL_FRAMEBUFFER_SRGB,    GL_SAMPLE_MASK,
                               GL_SAMPLE_COVERAGE,     GL_SAMPLE_ALPHA_TO_COVERAGE,
                               GL_SAMPLE_ALPHA_TO_ONE, GL_PROGRAM_POINT_SIZE,
                               GL_PRIMITIVE_RESTART,   GL_PRIMITIVE_RESTART_FIXED_INDEX,
                               GL_CLIP_DISTANCE0,      GL_CLIP_DISTANCE1,
                               GL_CLIP_DISTANCE2,      GL_CLIP_DISTANCE3,
                               GL_CLIP_DISTANCE4,      GL_CLIP_DISTANCE5,
                               GL_CLIP_DISTANCE6,      GL_CLIP_DISTANCE7};

}  // namespace

StateGuard::StateGuard(const Device& device, int blocks, int images, int storages)
    : gl_{device}, outer_{device.set_guard(this)}, blocks_(static_cast<std::size_t>(blocks)),
      storages_(static_cast<std::size_t>(storages)), images_(static_cast<std::size_t>(images))
{
    gl_->GetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &draw_framebuffer_);
    gl_->GetIntegerv(GL_CURRENT_PROGRAM, &program_);
    gl_->GetIntegerv(GL_VERTEX_ARRAY_BINDING, &vertex_array_);
    gl_->GetIntegerv(GL_ACTIVE_TEXTURE, &active_texture_);
    gl_->GetIntegerv(GL_UNIFORM_BUFFER_BINDING, &uniform_buffer_);
    gl_->GetIntegerv(GL_DISPATCH_INDIRECT_BUFFER_BINDING, &dispatch_buffer_);
    if (storages > 0)
        gl_->GetIntegerv(GL_SHADER_STORAGE_BUFFER_BINDING, &storage_buffer_);
    gl_->GetIntegerv(GL_CULL_FACE_MODE, &cull_mode_);
    gl_->GetIntegerv(GL_FRONT_FACE, &front_face_);
    gl_->GetIntegerv(GL_PROVOKING_VERTEX, &provoking_vertex_);
    gl_->GetIntegerv(GL_DEPTH_FUNC, &depth_func_);
    gl_->GetIntegerv(GL_CLIP_ORIGIN, &clip_origin_);
    gl_->GetIntegerv(GL_CLIP_DEPTH_MODE, &clip_depth_);
    gl_->GetIntegerv(GL_POLYGON_MODE, polygon_mode_.data());
    gl_->GetFloati_v(GL_VIEWPORT, 0, viewport_.data());
    gl_->GetFloatv(GL_BLEND_COLOR, blend_color_.data());
    gl_->GetDoublei_v(GL_DEPTH_RANGE, 0, depth_range_.data());
    scissor_ = gl_->IsEnabledi(GL_SCISSOR_TEST, 0);
    gl_->GetIntegeri_v(GL_SCISSOR_BOX, 0, scissor_box_.data());
    gl_->Disablei(GL_SCISSOR_TEST, 0);
    gl_->GetFloatv(GL_LINE_WIDTH, &line_width_);
    gl_->GetFloatv(GL_POLYGON_OFFSET_FACTOR, &offset_factor_);
    gl_->GetFloatv(GL_POLYGON_OFFSET_UNITS, &offset_units_);
    gl_->GetBooleanv(GL_DEPTH_WRITEMASK, &depth_mask_);
    for (GLenum name : kSwitches) {
        enabled_.push_back(gl_->IsEnabled(name));
        gl_->Disable(name);
    }
    for (GLuint i = 0; i < kDrawBuffers; ++i) {
        Blend& blend = blend_.at(i);
        gl_->GetIntegeri_v(GL_BLEND_SRC_RGB, i, &blend.src_rgb);
        gl_->GetIntegeri_v(GL_BLEND_DST_RGB, i, &blend.dst_rgb);
        gl_->GetIntegeri_v(GL_BLEND_SRC_ALPHA, i, &blend.src_alpha);
        gl_->GetIntegeri_v(GL_BLEND_DST_ALPHA, i, &blend.dst_alpha);
        gl_->GetIntegeri_v(GL_BLEND_EQUATION_RGB, i, &blend.equation_rgb);
        gl_->GetIntegeri_v(GL_BLEND_EQUATION_ALPHA, i, &blend.equation_alpha);
        gl_->GetBooleani_v(GL_COLOR_WRITEMASK, i, blend.color_mask.data());
        blend.enabled = gl_->IsEnabledi(GL_BLEND, i);
        gl_->Disablei(GL_BLEND, i);
        gl_->ColorMaski(i, GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    }
    const auto note = [&](std::vector<Block>& of, GLenum binding, GLenum start, GLenum size) {
        for (GLuint i = 0; i < of.size(); ++i) {
            Block& block = of[i];
            gl_->GetIntegeri_v(binding, i, &block.buffer);
            gl_->GetInteger64i_v(start, i, &block.offset);
            gl_->GetInteger64i_v(size, i, &block.size);
        }
    };
    note(blocks_, GL_UNIFORM_BUFFER_BINDING, GL_UNIFORM_BUFFER_START, GL_UNIFORM_BUFFER_SIZE);
    note(storages_, GL_SHADER_STORAGE_BUFFER_BINDING, GL_SHADER_STORAGE_BUFFER_START,
         GL_SHADER_STORAGE_BUFFER_SIZE);
    for (GLuint i = 0; i < images_.size(); ++i) {
        Image& image = images_[i];
        gl_->GetIntegeri_v(GL_IMAGE_BINDING_NAME, i, &image.texture);
        gl_->GetIntegeri_v(GL_IMAGE_BINDING_LEVEL, i, &image.level);
        gl_->GetBooleani_v(GL_IMAGE_BINDING_LAYERED, i, &image.layered);
        gl_->GetIntegeri_v(GL_IMAGE_BINDING_LAYER, i, &image.layer);
        gl_->GetIntegeri_v(GL_IMAGE_BINDING_ACCESS, i, &image.access);
        gl_->GetIntegeri_v(GL_IMAGE_BINDING_FORMAT, i, &image.format);
    }
    gl_->PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    gl_->ClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    gl_->DepthRangeIndexed(0, 0.0, 1.0);
    gl_->FrontFace(GL_CCW);
    gl_->LineWidth(1.0f);
    gl_->ProvokingVertex(GL_LAST_VERTEX_CONVENTION);  // it decides a triangle's last bits
    gl_->DepthMask(GL_FALSE);
}

void StateGuard::take_unit(GLuint number)
{
    assert(number < 128);
    std::uint64_t& taken = taken_[number / 64];
    const std::uint64_t bit = std::uint64_t{1} << number % 64;
    if ((taken & bit) != 0)
        return;
    taken |= bit;
    Unit unit;
    unit.number = number;
    gl_->ActiveTexture(GL_TEXTURE0 + number);
    gl_->GetIntegerv(GL_TEXTURE_BINDING_2D, &unit.texture_2d);
    gl_->GetIntegerv(GL_TEXTURE_BINDING_3D, &unit.texture_3d);
    gl_->GetIntegerv(GL_TEXTURE_BINDING_2D_ARRAY, &unit.texture_2d_array);
    gl_->GetIntegerv(GL_SAMPLER_BINDING, &unit.sampler);
    gl_->BindSampler(number, 0);
    units_.push_back(unit);
}

void Device::take_texture_unit(GLuint unit) const
{
    if (guard_ != nullptr)
        guard_->take_unit(unit);
}

StateGuard::~StateGuard()
{
    gl_.set_guard(outer_);
    for (GLuint i = 0; i < images_.size(); ++i) {
        const Image& image = images_[i];
        gl_->BindImageTexture(i, static_cast<GLuint>(image.texture), image.level, image.layered,
                              image.layer, static_cast<GLenum>(image.access),
                              static_cast<GLenum>(image.format));
    }
    const auto put_back = [&](GLenum target, const std::vector<Block>& blocks, GLint generic) {
        for (GLuint i = 0; i < blocks.size(); ++i) {
            const Block& block = blocks[i];
            const auto buffer = static_cast<GLuint>(block.buffer);
            if (block.size > 0)
                gl_->BindBufferRange(target, i, buffer, static_cast<GLintptr>(block.offset),
                                     static_cast<GLsizeiptr>(block.size));
            else
                gl_->BindBufferBase(target, i, buffer);
        }
        gl_->BindBuffer(target, static_cast<GLuint>(generic));
    };
    put_back(GL_UNIFORM_BUFFER, blocks_, uniform_buffer_);
    if (!storages_.empty())
        put_back(GL_SHADER_STORAGE_BUFFER, storages_, storage_buffer_);
    gl_->BindBuffer(GL_DISPATCH_INDIRECT_BUFFER, static_cast<GLuint>(dispatch_buffer_));
    for (const Unit& unit : units_) {
        gl_->ActiveTexture(GL_TEXTURE0 + unit.number);
        gl_->BindTexture(GL_TEXTURE_2D, static_cast<GLuint>(unit.texture_2d));
        gl_->BindTexture(GL_TEXTURE_3D, static_cast<GLuint>(unit.texture_3d));
        gl_->BindTexture(GL_TEXTURE_2D_ARRAY, static_cast<GLuint>(unit.texture_2d_array));
        gl_->BindSampler(unit.number, static_cast<GLuint>(unit.sampler));
    }
    gl_->ActiveTexture(static_cast<GLenum>(active_texture_));
    for (GLuint i = 0; i < kDrawBuffers; ++i) {
        const Blend& blend = blend_.at(i);
        gl_->BlendFuncSeparatei(
            i, static_cast<GLenum>(blend.src_rgb), static_cast<GLenum>(blend.dst_rgb),
            static_cast<GLenum>(blend.src_alpha), static_cast<GLenum>(blend.dst_alpha));
        gl_->BlendEquationSeparatei(i, static_cast<GLenum>(blend.equation_rgb),
                                    static_cast<GLenum>(blend.equation_alpha));
        gl_->ColorMaski(i, blend.color_mask[0], blend.color_mask[1], blend.color_mask[2],
                        blend.color_mask[3]);
        if (blend.enabled == GL_TRUE)
            gl_->Enablei(GL_BLEND, i);
        else
            gl_->Disablei(GL_BLEND, i);
    }
    for (std::size_t i = 0; i < kSwitches.size(); ++i) {
        if (enabled_[i] == GL_TRUE)
            gl_->Enable(kSwitches.at(i));
        else
            gl_->Disable(kSwitches.at(i));
    }
    gl_->DepthMask(depth_mask_);
    gl_->DepthFunc(static_cast<GLenum>(depth_func_));
    gl_->LineWidth(line_width_);
    gl_->PolygonOffset(offset_factor_, offset_units_);
    gl_->DepthRangeIndexed(0, depth_range_[0], depth_range_[1]);
    gl_->ScissorIndexed(0, scissor_box_[0], scissor_box_[1], scissor_box_[2], scissor_box_[3]);
    if (scissor_ == GL_TRUE)
        gl_->Enablei(GL_SCISSOR_TEST, 0);
    gl_->BlendColor(blend_color_[0], blend_color_[1], blend_color_[2], blend_color_[3]);
    gl_->ViewportIndexedf(0, viewport_[0], viewport_[1], viewport_[2], viewport_[3]);
    gl_->PolygonMode(GL_FRONT_AND_BACK, static_cast<GLenum>(polygon_mode_[0]));
    gl_->ClipControl(static_cast<GLenum>(clip_origin_), static_cast<GLenum>(clip_depth_));
    gl_->FrontFace(static_cast<GLenum>(front_face_));
    gl_->ProvokingVertex(static_cast<GLenum>(provoking_vertex_));
    gl_->CullFace(static_cast<GLenum>(cull_mode_));
    gl_->BindVertexArray(static_cast<GLuint>(vertex_array_));
    gl_->UseProgram(static_cast<GLuint>(program_));
    gl_->BindFramebuffer(GL_DRAW_FRAMEBUFFER, static_cast<GLuint>(draw_framebuffer_));
}

}  // namespace fumarole::gl
