#include "resolve/march_history.h"

#include <fmt/format.h>

#include "pass/layer_format.h"
#include "shared/bindings.h"

namespace fumarole::resolve {

using pass::HistoryUse, pass::HistoryView, pass::SceneChange;

namespace {

/// Of what is kept: with an alpha, which the small format has not.
GLenum kept_format(const FrameSettings& s)
{
    switch (s.history_format) {
    case Settings::Format::automatic:
        return GL_RGBA32F;
    case Settings::Format::r11g11b10f:
        return GL_RGBA16F;
    default:
        return pass::gl_format(s.history_format);
    }
}

}  // namespace

MarchHistory::MarchHistory(const Toolbox& tools)
    : tools_{tools}, block_{tools.device, "march history"}
{
}

void MarchHistory::fit(const PreparedFrame& frame)
{
    const gl::Device& gl = tools_.device;
    const Shape shape{frame.layer_size, frame.picture_size, kept_format(frame.settings),
                      tools_.monochrome(frame.settings)};
    if (view_.shape == shape)
        return;
    view_ = {};
    view_.shape = shape;
    // Beside monochrome scattering: a number of frames and a fraction of depth.
    const GLenum more = shape.monochrome ? GL_RG32F : shape.format;
    for (Kept& layer : view_.layers) {
        layer.scattering = gl::Texture::make_2d(gl, "kept scattering", shape.texels, shape.format,
                                                gl::Filter::linear);
        layer.more =
            gl::Texture::make_2d(gl, "kept beside it", shape.texels, more, gl::Filter::linear);
        layer.framebuffer = {gl, "march history"};
        layer.framebuffer.attach_color({layer.scattering.view(), layer.more.view()});
    }
}

void MarchHistory::write_block(const PreparedFrame& frame, const View& view, float weight) const
{
    const HistoryView& last = *view.last;
    const glm::dvec2 offset = view.last_offset - glm::dvec2(frame.layer_guard);
    shared::MarchHistoryParams params{};
    params.clip_from_world = glm::mat4(pass::clip_from_eye(last, frame.eye.position));
    params.view_z_from_world = glm::vec4(pass::view_z_from_eye(last, frame.eye.position));
    params.media_range = glm::vec2(view.last_media_range);
    params.media_depth = static_cast<float>(depth_reach(frame.eye, view.last_media_range));
    params.eye = pass::eye_from_eye(last, frame.eye);
    params.layer_offset = glm::vec2(offset);
    params.weight = weight;
    block_.write(params);
    tools_.device->BindBufferBase(GL_UNIFORM_BUFFER, MARCH_HISTORY_BLOCK, block_.id());
}

void MarchHistory::add(const PreparedFrame& frame, const pass::MarchedLayer& marched)
{
    const auto time = tools_.timers.scope("march history");
    const gl::Device& gl = tools_.device;
    fit(frame);
    View& view = view_;
    const HistoryView now = pass::make_history_view(frame);
    use_ = pass::judge_history(true, view.last, now);
    if (use_ == HistoryUse::still && view.last_offset != frame.host.layer_offset)
        use_ = HistoryUse::moved;
    change_ = has_history(use_) ? change_since(view.last, now) : SceneChange::none;
    gl::Defines defines;
    if (use_ == HistoryUse::moved)
        defines = tools_.scattering_defines(frame.settings);
    defines.emplace_back("kLayerScale", fmt::format("{}", frame.settings.resolution));
    const auto add_define = [&](bool condition, const char* name) {
        if (condition)
            defines.emplace_back(name, "");
    };
    add_define(view.shape.monochrome, "MONOCHROME");
    add_define(pass::has_history(use_), "kHistory");
    add_define(use_ == HistoryUse::moved, "HISTORY_MOVED");
    add_define(change_ != SceneChange::none, "kLightChanged");
    add_define(change_ == SceneChange::media, "kMediaChanged");
    const float weight = view.weight.next(use_, frame.settings.history);
    if (view.last)
        write_block(frame, view, weight);

    const Kept& kept = view.layers.at(view.current);
    view.current = 1 - view.current;
    const Kept& mean = view.layers.at(view.current);
    marched.scattering->bind(SCATTERING_UNIT);
    marched.transmittance->bind(TRANSMITTANCE_UNIT);
    kept.scattering.bind(KEPT_UNIT);
    kept.more.bind(KEPT_MORE_UNIT);
    if (marched.tiles->computes()) {
        mean.scattering.bind_image(LAYER_IMAGE, GL_WRITE_ONLY);
        mean.more.bind_image(LAYER_MORE_IMAGE, GL_WRITE_ONLY);
    } else {
        mean.framebuffer.bind(view.shape.texels);
    }
    // Where no medium is in the way nothing is drawn: one frame's worth of that, whatever the
    // depth.
    constexpr std::array<GLfloat, 4> kNothing{0, 0, 0, 1}, kAll{1, 1, 1, -1}, kState{1, -1, 0, 0};
    gl->ClearNamedFramebufferfv(mean.framebuffer.id(), GL_COLOR, 0, kNothing.data());
    gl->ClearNamedFramebufferfv(mean.framebuffer.id(), GL_COLOR, 1,
                                (view.shape.monochrome ? kState : kAll).data());
    marched.tiles->run_tiles("pass/march_history", defines);
    if (marched.tiles->computes())
        gl->MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    view.last = now;
    view.last_media_range = frame.media_range;
    view.last_offset = frame.host.layer_offset;
}

void MarchHistory::replace(pass::MarchedLayer& marched) const
{
    if (!view_.last)
        return;
    const Kept& mean = view_.layers.at(static_cast<std::size_t>(view_.current));
    marched.scattering = &mean.scattering;
    marched.transmittance = &mean.more;
}

}  // namespace fumarole::resolve
