#include "pass/froxels.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>

#include "halton.h"
#include "pass/layer_format.h"
#include "shared/bindings.h"
#include <fumarole/errors.h>

namespace fumarole::pass {

namespace {

/// Of what is integrated, more than froxels have: both ends of the slices, and for a lookup that
/// reaches past them one more before the first and one behind the last.
int end_slices(const FrameSettings& s)
{
    return s.lookup == Settings::Lookup::tricubic ? 3 : 1;
}

/// Of a view at rest, the largest weight of a history that is dithered. A mean of ever more frames
/// forgets its own roundings ever more slowly, so their sum would grow without an end.
constexpr float kMostDithered = 4095.0f / 4096;

constexpr glm::ivec3 kFroxelGroup(FROXEL_GROUP_X, FROXEL_GROUP_Y, FROXEL_GROUP_Z);

/// Columns beyond the picture on each side, so that a lookup at its edge finds all its texels.
int guard_columns(const FrameSettings& s)
{
    return s.lookup == Settings::Lookup::tricubic ? 2 : 1;
}

glm::ivec3 froxel_count(const PreparedFrame& frame)
{
    const FrameSettings& s = frame.settings;
    const glm::ivec2 columns = (frame.picture_size + s.tile - 1) / s.tile;
    return {columns + 2 * guard_columns(s), s.slices};
}

GLenum history_format(const FrameSettings& s)
{
    if (s.history_format != Settings::Format::automatic)
        return gl_format(s.history_format);
    return s.format == Settings::Format::rgba32f ? GL_RGBA32F : GL_RGBA16F;
}

/// @param alpha whether the volumes' formats have one
FroxelExtinction extinction_of(const Toolbox& tools, bool alpha)
{
    if (!alpha)
        return FroxelExtinction::apart;
    if (!tools.media.traits().colored_extinction)
        return FroxelExtinction::grey;
    return tools.media.extinction_color() ? FroxelExtinction::one_color
                                          : FroxelExtinction::red_in_alpha;
}

/// Of the volume that has what is not in the alpha of another one.
GLenum format_apart(FroxelExtinction extinction, GLenum format)
{
    if (extinction == FroxelExtinction::apart)
        return format;
    return format == GL_RGBA32F ? GL_RG32F : GL_RG16F;
}

/// But for the size.
FroxelPlan make_plan(const Toolbox& tools, const FrameSettings& s, bool history)
{
    const medium::MediaTraits& media = tools.media.traits();
    FroxelPlan plan;
    plan.format = gl_format(s.format);
    plan.history = history;
    plan.source_format = plan.history ? history_format(s) : plan.format;
    plan.dithered = plan.history && plan.source_format == GL_RGBA16F;
    plan.extinction = extinction_of(tools, plan.format != GL_R11F_G11F_B10F &&
                                               plan.source_format != GL_R11F_G11F_B10F);
    plan.v_buffer = s.froxel_shadows == Settings::FroxelShadows::grid;
    plan.emission = media.emission;
    plan.mixed_g = media.mixed_g;
    return plan;
}

FroxelPlan make_plan(const Toolbox& tools, const PreparedFrame& frame)
{
    FroxelPlan plan = make_plan(tools, frame.settings, frame.keeps_history);
    plan.count = froxel_count(frame);
    plan.integrated_slices = plan.count.z + end_slices(frame.settings);
    plan.picture = frame.picture_size;
    return plan;
}

int bytes_of(GLenum format)
{
    switch (format) {
    case GL_R11F_G11F_B10F:
    case GL_RG16F:
        return 4;
    case GL_RGBA32F:
        return 16;
    default:
        return 8;
    }
}

/// Of a froxel's source and extinction, twice, and of what is integrated where it lies apart.
int bytes_of(const FroxelPlan& plan)
{
    const auto apart = [&](GLenum format) {
        return bytes_of(format_apart(plan.extinction, format));
    };
    int bytes =
        2 * (bytes_of(plan.source_format) + (plan.one_number() ? 0 : apart(plan.source_format)));
    if (!plan.shares())
        bytes += bytes_of(plan.format);
    if (plan.transmittance_apart())
        bytes += apart(plan.format);
    return bytes;
}

void check_size(const FroxelPlan& plan, const gl::Device& gl)
{
    const glm::ivec3 count = plan.count;
    const int limit = gl.capabilities().max_texture_3d;
    if (std::max({count.x, count.y, plan.integrated_slices}) > limit)
        throw Error(
            fmt::format("{} x {} x {} froxels are more than this GL's 3-D textures hold ({} "
                        "a side); give a larger FrameSettings::tile or fewer FrameSettings::slices",
                        count.x, count.y, count.z, limit));
}

/// The slices between two view depths.
shared::SliceParams slices_of(const FrameSettings& s, bool perspective, glm::dvec2 range)
{
    shared::SliceParams slices{};
    slices.begin = static_cast<float>(range.x);
    slices.end = static_cast<float>(range.y);
    slices.depth = static_cast<float>(range.y - range.x);
    slices.count = static_cast<float>(s.slices);
    slices.spacing = SLICES_LINEAR;
    slices.rate = slices.exp2_rate_1 = slices.rescale = 1;
    // 2017 held 1 - distribution to a hundredth: exp2(25) is the last spacing with a first slice.
    const double rest = std::max(1.0 - static_cast<double>(s.distribution), 0.01);
    if (!perspective || s.slice_spacing == Settings::SliceSpacing::linear)
        return slices;
    if (s.slice_spacing == Settings::SliceSpacing::power) {
        slices.spacing = SLICES_POWER;
        slices.rate = static_cast<float>(1 / rest);
        return slices;
    }
    const double rate = 0.25 / rest;
    slices.spacing = SLICES_EXPONENTIAL;
    slices.rate = static_cast<float>(rate);
    slices.exp2_rate_1 = static_cast<float>(std::exp2(rate) - 1);
    return slices;
}

/// Where in their froxels this frame's samples lie; frame 0 has them in the middle.
glm::dvec3 jitter_of(const PreparedFrame& frame)
{
    if (frame.settings.jitter == Settings::Jitter::none)
        return glm::dvec3(0.5);
    const std::uint64_t i = frame.host.index;
    return glm::fract(
        glm::dvec3(radical_inverse(i, 2), radical_inverse(i, 3), radical_inverse(i, 7)) + 0.5);
}

gl::Defines storage_defines(FroxelExtinction extinction)
{
    switch (extinction) {
    case FroxelExtinction::grey:
        return {{"EXTINCTION_IN_ALPHA", ""}};
    case FroxelExtinction::one_color:
        return {{"kOneColor", ""}, {"kRedInAlpha", ""}};
    case FroxelExtinction::red_in_alpha:
        return {{"kRedInAlpha", ""}};
    case FroxelExtinction::apart:
        break;
    }
    return {};
}

/// Of the steps that sample the media.
gl::Defines sampling_defines(const Toolbox& tools, const FrameSettings& s, const FroxelPlan& plan)
{
    gl::Defines defines = tools.scattering_defines(s);
    defines += storage_defines(plan.extinction);
    if (s.range == Settings::Range::camera)
        defines.emplace_back("kCameraRange", "");
    if (plan.dithered)
        defines.emplace_back("kDithered", "");
    if (plan.v_buffer)
        defines += {{"kGridShadows", "true"}, {"kDepthAtPoint", "false"}};
    return defines;
}

/// Binds a volume to be written; nothing where it is not there.
void bind_image(const gl::Device& gl, GLuint unit, const gl::Texture& volume, GLenum format)
{
    if (volume)
        gl->BindImageTexture(unit, volume.id(), 0, GL_TRUE, 0, GL_WRITE_ONLY, format);
}

}  // namespace

Froxels::Froxels(const Toolbox& tools) : VolumePass{tools}, block_{tools.device, "froxels"} {}

Froxels::View& Froxels::view_of(const PreparedFrame& frame)
{
    const FroxelPlan plan = make_plan(tools_, frame);
    check_size(plan, tools_.device);
    View& view = view_;
    if (view.plan == plan)
        return view;
    view = {};
    view.plan = plan;
    const auto make = [&](const char* label, GLenum format, glm::ivec3 size) {
        return gl::Texture::make_3d(tools_.device, label, size, format, gl::Filter::linear);
    };
    const glm::ivec3 integrated(plan.count.x, plan.count.y, plan.integrated_slices);
    if (plan.v_buffer) {
        view.sigma_s = make("V-buffer sigma_s", plan.format, plan.count);
        if (!plan.one_number())
            view.sigma_t = make("V-buffer sigma_t", plan.format, plan.count);
        if (plan.emission)
            view.emission = make("V-buffer emission", plan.format, plan.count);
        if (plan.mixed_g)
            view.phase = make("V-buffer phase", GL_RG16F, plan.count);
    }
    for (int i = 0; i < 2; ++i) {
        const auto make_shared = [&](const char* label, GLenum format) {
            gl::Texture volume = make(label, format, plan.shares() ? integrated : plan.count);
            // A lookup at the last slice multiplies the one behind it by 0, and must find a number.
            volume.clear(GL_RGBA, GL_FLOAT, nullptr);
            return volume;
        };
        view.source.at(i) =
            make_shared("froxel source, then integrated scattering", plan.source_format);
        if (!plan.one_number())
            view.extinction.at(i) = make_shared("froxel extinction, then integrated transmittance",
                                                format_apart(plan.extinction, plan.source_format));
    }
    if (!plan.shares())
        view.own_scattering = make("integrated scattering", plan.format, integrated);
    if (plan.transmittance_apart())
        view.own_transmittance = make("integrated transmittance",
                                      format_apart(plan.extinction, plan.format), integrated);
    return view;
}

shared::FroxelParams Froxels::params(const PreparedFrame& frame, const View& view,
                                     float history_weight) const
{
    const HistoryView now = make_history_view(frame);
    const HistoryView& last = view.last ? *view.last : now;
    const auto slices = [&](glm::dvec2 range) {
        return slices_of(frame.settings, frame.eye.perspective, range);
    };
    shared::FroxelParams params{};
    params.slices = slices(now.range);
    params.columns = glm::vec2(view.plan.count);
    params.tile_pixels = static_cast<float>(frame.settings.tile);
    params.guard_columns = static_cast<float>(guard_columns(frame.settings));
    params.jitter = glm::vec3(jitter_of(frame));
    params.history_weight = history_weight;
    params.clip_from_world = glm::mat4(clip_from_eye(now, now.eye));
    params.view_z_from_world = glm::vec4(view_z_from_eye(now, now.eye));
    params.history_clip_from_world = glm::mat4(clip_from_eye(last, now.eye));
    params.history_view_z_from_world = glm::vec4(view_z_from_eye(last, now.eye));
    params.history_slices = slices(last.range);
    params.history_slices.rescale =
        static_cast<float>((now.range.y - now.range.x) / (last.range.y - last.range.x));
    params.history_eye = eye_from_eye(last, frame.eye);
    params.extinction_color = tools_.media.extinction_color().value_or(glm::vec3(1));
    params.dithered_frame = view.dithered_frame;
    return params;
}

void Froxels::write_block(const PreparedFrame& frame, const View& view, float history_weight) const
{
    block_.write(params(frame, view, history_weight));
    tools_.device->BindBufferBase(GL_UNIFORM_BUFFER, FROXEL_BLOCK, block_.id());
}

void Froxels::dispatch(const char* file, const gl::Defines& defines, glm::ivec3 invocations,
                       glm::ivec3 group) const
{
    const gl::Device& gl = tools_.device;
    gl->UseProgram(tools_.programs.get({file}, defines).id());
    const glm::uvec3 groups((invocations + group - 1) / group);
    gl->DispatchCompute(groups.x, groups.y, groups.z);
    // For the next step's fetches; and its stores wait until this one has read.
    gl->MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
}

void Froxels::draw_v_buffer(const PreparedFrame& frame, const View& view) const
{
    const gl::Device& gl = tools_.device;
    const FroxelPlan& plan = view.plan;
    bind_image(gl, V_BUFFER_SIGMA_S_IMAGE, view.sigma_s, plan.format);
    bind_image(gl, V_BUFFER_SIGMA_T_IMAGE, view.sigma_t, plan.format);
    bind_image(gl, V_BUFFER_EMISSION_IMAGE, view.emission, plan.format);
    bind_image(gl, V_BUFFER_PHASE_IMAGE, view.phase, GL_RG16F);
    dispatch("pass/v_buffer.comp", sampling_defines(tools_, frame.settings, plan), plan.count,
             kFroxelGroup);
}

void Froxels::bind_v_buffer(const View& view) const
{
    view.sigma_s.bind(V_BUFFER_SIGMA_S_UNIT);
    view.sigma_t.bind(V_BUFFER_SIGMA_T_UNIT);
    view.emission.bind(V_BUFFER_EMISSION_UNIT);
    view.phase.bind(V_BUFFER_PHASE_UNIT);
}

void Froxels::scatter(const PreparedFrame& frame, View& view, HistoryUse use) const
{
    const FroxelPlan& plan = view.plan;
    gl::Defines defines = sampling_defines(tools_, frame.settings, plan);
    if (plan.history) {
        bind_history(view);
        view.current = 1 - view.current;
    }
    const bool apart = static_cast<bool>(view.frame_source);
    if (has_history(use) && !apart)
        defines.emplace_back("kHistory", "");
    if (use == HistoryUse::still && !apart)
        defines.emplace_back("kHistoryStill", "");
    if (change_ != SceneChange::none)
        defines.emplace_back("kMiddleLight", "");
    bind_v_buffer(view);
    if (apart)
        bind_kept(view, view.frame_source, view.frame_extinction);
    else
        bind_kept(view, view.source.at(view.current), view.extinction.at(view.current));
    dispatch("pass/scatter.comp", defines, plan.count, kFroxelGroup);
}

void Froxels::bind_kept(const View& view, const gl::Texture& source,
                        const gl::Texture& extinction) const
{
    const FroxelPlan& plan = view.plan;
    bind_image(tools_.device, FROXEL_SOURCE_IMAGE, source, plan.source_format);
    bind_image(tools_.device, FROXEL_EXTINCTION_IMAGE, extinction,
               format_apart(plan.extinction, plan.source_format));
}

void Froxels::bind_history(const View& view) const
{
    view.source.at(view.current).bind(FROXEL_HISTORY_UNIT);
    view.extinction.at(view.current).bind(FROXEL_HISTORY_EXTINCTION_UNIT);
}

void Froxels::make_counts(View& view) const
{
    const FroxelPlan& plan = view.plan;
    const auto make = [&](const char* label, GLenum format) {
        return gl::Texture::make_3d(tools_.device, label, plan.count, format, gl::Filter::nearest);
    };
    view.frame_source = make("froxel source of a frame", plan.source_format);
    if (!plan.one_number())
        view.frame_extinction =
            make("froxel extinction of a frame", format_apart(plan.extinction, plan.source_format));
    for (gl::Texture& counts : view.counts)
        counts = gl::Texture::make_3d(tools_.device, "froxel frames", plan.count, GL_RG16F,
                                      gl::Filter::linear);
}

void Froxels::add_history(const PreparedFrame& frame, View& view, SceneChange change) const
{
    const gl::Device& gl = tools_.device;
    const FroxelPlan& plan = view.plan;
    gl::Defines defines = sampling_defines(tools_, frame.settings, plan);
    const auto add = [&](bool condition, const char* name) {
        if (condition)
            defines.emplace_back(name, "");
    };
    add(view.counted, "kCounted");
    add(change != SceneChange::none, "kLightChanged");
    add(change == SceneChange::media, "kMediaChanged");
    const int now = view.current;
    view.frame_source.bind(FROXEL_SOURCE_UNIT);
    view.frame_extinction.bind(FROXEL_EXTINCTION_UNIT);
    view.counts.at(1 - now).bind(FROXEL_COUNTS_UNIT);
    bind_v_buffer(view);
    bind_kept(view, view.source.at(now), view.extinction.at(now));
    bind_image(gl, FROXEL_COUNTS_IMAGE, view.counts.at(now), GL_RG16F);
    dispatch("pass/froxel_history.comp", defines, plan.count, kFroxelGroup);
    view.counted = true;
}

void Froxels::integrate(const PreparedFrame& frame, const View& view) const
{
    const gl::Device& gl = tools_.device;
    const FroxelPlan& plan = view.plan;
    gl::Defines defines = storage_defines(plan.extinction);
    if (frame.settings.integration == Settings::Integration::wronski)
        defines.emplace_back("kWronski", "");
    if (frame.settings.lookup == Settings::Lookup::tricubic)
        defines.emplace_back("kTricubic", "");
    view.source.at(view.current).bind(FROXEL_SOURCE_UNIT);
    view.extinction.at(view.current).bind(FROXEL_EXTINCTION_UNIT);
    bind_image(gl, INTEGRATED_SCATTERING_IMAGE, view.scattering(), plan.format);
    bind_image(gl, INTEGRATED_TRANSMITTANCE_IMAGE, view.transmittance(),
               format_apart(plan.extinction, plan.format));
    dispatch("pass/integrate.comp", defines, {plan.count.x, plan.count.y, 1},
             {FROXEL_COLUMNS, FROXEL_COLUMNS, 1});
}

void Froxels::draw(const PreparedFrame& frame)
{
    View& view = view_of(frame);
    const HistoryView now = make_history_view(frame);
    use_ = judge_history(view.plan.history, view.last, now);
    change_ = has_history(use_) ? change_since(view.last, now) : SceneChange::none;
    if (!has_history(use_)) {
        view.frame_source = {};
        view.frame_extinction = {};
        view.counts = {};
        view.counted = false;
    } else if (change_ != SceneChange::none && !view.frame_source) {
        make_counts(view);
    }
    view.dithered_frame = has_history(use_) ? view.dithered_frame + 1 : 0;
    float weight = view.weight.next(use_, frame.settings.history);
    if (view.plan.dithered)
        weight = std::min(weight, std::max(kMostDithered, frame.settings.history));
    write_block(frame, view, weight);
    if (view.plan.v_buffer) {
        const auto time = tools_.timers.scope("froxel media");
        draw_v_buffer(frame, view);
    }
    {
        const auto time = tools_.timers.scope("froxel light");
        scatter(frame, view, use_);
    }
    if (view.frame_source) {
        const auto time = tools_.timers.scope("froxel history");
        add_history(frame, view, change_);
    }
    {
        const auto time = tools_.timers.scope("froxel integration");
        integrate(frame, view);
    }
    view.last = now;
}

IntegratedFroxels Froxels::integrated() const
{
    FroxelExtinction storage = view_.plan.extinction;
    if (storage == FroxelExtinction::one_color)
        storage = FroxelExtinction::red_in_alpha;
    return {&view_.scattering(), &view_.transmittance(), storage, storage_defines(storage)};
}

gl::Texture Froxels::sample_counts(const PreparedFrame& frame)
{
    const gl::Device& gl = tools_.device;
    View& view = view_of(frame);
    write_block(frame, view, 0);
    if (view.plan.v_buffer)
        draw_v_buffer(frame, view);
    gl::Texture counts =
        gl::Texture::make_3d(gl, "sample counts", view.plan.count, GL_R32F, gl::Filter::nearest);
    bind_v_buffer(view);
    bind_image(gl, FROXEL_SOURCE_IMAGE, counts, GL_R32F);
    gl::Defines defines = sampling_defines(tools_, frame.settings, view.plan);
    defines.emplace_back("kCountSamples", "");
    dispatch("pass/scatter.comp", defines, view.plan.count, kFroxelGroup);
    gl->MemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT);  // for who reads it back
    return counts;
}

void Froxels::show_samples(const PreparedFrame& frame, const gl::Texture& counts)
{
    write_block(frame, view_of(frame), 0);
    counts.bind(INSPECTED_UNIT);
    tools_.draw_fullscreen("pass/inspect_froxels.frag", {{"kSamples", ""}});
}

void Froxels::show_slice(const PreparedFrame& frame)
{
    const View& view = view_of(frame);
    write_block(frame, view, 0);
    view.source.at(view.current).bind(INSPECTED_UNIT);
    tools_.draw_fullscreen("pass/inspect_froxels.frag", {});
}

std::vector<std::string> explain_froxels(const Toolbox& tools, const FrameSettings& s)
{
    const medium::MediaTraits& media = tools.media.traits();
    const FroxelPlan plan = make_plan(tools, s, s.keeps_history());
    std::vector<std::string> lines;
    lines.push_back(fmt::format("froxels: tiles of {} x {} pixels, {} slices over the depth of {}",
                                s.tile, s.tile, s.slices,
                                s.range == Settings::Range::media ? "the media" : "the view"));
    lines.push_back(fmt::format(
        "of a froxel: its source and {}, {} bytes with what is integrated",
        plan.extinction == FroxelExtinction::grey        ? "one number of grey extinction"
        : plan.extinction == FroxelExtinction::one_color ? "one number of extinction of one colour"
                                                         : "three numbers of extinction",
        bytes_of(plan)));
    if (plan.v_buffer)
        lines.push_back(fmt::format("V-buffer: sigma_s, {}{}{}",
                                    plan.one_number() ? "the number of sigma_t in its alpha"
                                                      : "a volume for sigma_t",
                                    media.emission ? ", one for emission" : "",
                                    media.mixed_g ? ", one for the phase" : ""));
    return lines;
}

}  // namespace fumarole::pass
