#include "pass/ray_march.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <iterator>

#include "pass/layer_format.h"
#include "shared/aureole.h"
#include "shared/bindings.h"

namespace fumarole::pass {

namespace {

constexpr const char* kMarch = "pass/ray_march";

}  // namespace

Settings::Format march_format(const Toolbox& tools, const FrameSettings& s)
{
    const bool small = s.format == Settings::Format::r11g11b10f;
    return (tools.monochrome(s) || s.keeps_history()) && small ? Settings::Format::rgba16f
                                                               : s.format;
}

bool RayMarch::has_aureoles() const
{
    return tools_.media.splits_forward_peaks() && tools_.lights.suns() > 0 &&
           tools_.scene_settings.volume_shadows;
}

bool RayMarch::sees_aureole(const PreparedFrame& frame) const
{
    const ViewCone cone = view_cone(frame.rays);
    const double reach = std::acos(AUREOLE_NONE) + cone.half_angle;
    return has_aureoles() &&
           std::ranges::any_of(tools_.lights.points(), [&](const LightPosition& light) {
               return light.far &&
                      std::acos(std::clamp(glm::dot(glm::normalize(light.at), cone.axis), -1.0,
                                           1.0)) < reach;
           });
}

gl::Defines RayMarch::march_defines(const PreparedFrame& frame) const
{
    const FrameSettings& s = frame.settings;
    gl::Defines defines = tools_.scattering_defines(s);
    const auto add = [&](bool condition, const char* name) {
        if (condition)
            defines.emplace_back(name, "");
    };
    add(s.jitter == Settings::Jitter::blue, "kBlueNoise");
    add(s.range == Settings::Range::camera, "kCameraRange");
    add(tools_.monochrome(s), "kMonochrome");
    add(s.falloff == Settings::Falloff::exact, "kExactFalloff");
    add(frame.fine && tools_.lights.suns() > 0, "kSteepSuns");  // else it is fine for lamps
    // In media with a closed form: detail of others is better met where it is.
    add(frame.fine && tools_.media.traits().marched == 0, "kShadeOverStep");
    // Where a shadow ends within a step, what it has of the light is told by a few places: far
    // fewer than steps that short would cost, as the media are not asked again. Steps are as short
    // as a medium's detail anyway, and shadows count for less there.
    if (s.range != Settings::Range::camera && tools_.media.traits().marched == 0)
        defines.emplace_back("kShadowTaps", "4");
    defines.emplace_back("kLayerScale", fmt::format("{}", s.resolution));
    return defines;
}

void RayMarch::resize(const PreparedFrame& frame)
{
    const gl::Device& gl = tools_.device;
    const Settings::Format format = march_format(tools_, frame.settings);
    const bool monochrome = tools_.monochrome(frame.settings);
    const bool media_depth = frame.keeps_history;
    guard_ = frame.layer_guard;
    scale_ = frame.settings.resolution;
    if (frame.layer_size == size_ && format == format_ && monochrome == monochrome_ &&
        media_depth == has_media_depth_)
        return;
    size_ = frame.layer_size;
    format_ = format;
    monochrome_ = monochrome;
    has_media_depth_ = media_depth;
    const GLenum color = gl_format(format);
    depth_ = gl::Texture::make_2d(gl, "layer depth", size_, GL_R32F, gl::Filter::nearest);
    scattering_ = gl::Texture::make_2d(gl, "layer scattering", size_, color, gl::Filter::nearest);
    transmittance_ = {};
    depth_framebuffer_ = {gl, "layer depth"};
    depth_framebuffer_.attach_color({depth_.view()});
    framebuffer_ = {gl, "layer"};
    if (!monochrome)
        transmittance_ =
            gl::Texture::make_2d(gl, "layer transmittance", size_, color, gl::Filter::nearest);
    else if (media_depth)
        transmittance_ =
            gl::Texture::make_2d(gl, "layer media depth", size_, GL_RG32F, gl::Filter::nearest);
    if (transmittance_)
        framebuffer_.attach_color({scattering_.view(), transmittance_.view()});
    else
        framebuffer_.attach_color({scattering_.view()});
}

void RayMarch::resize_splits(const PreparedFrame& frame)
{
    const std::vector<float>& depths = frame.depths_asked.view_z;
    const int panes = frame.panes;
    const int count = panes > 0 ? panes : static_cast<int>(depths.size());
    if (count == 0) {
        split_scattering_ = {};
        split_transmittance_ = {};
        return;
    }
    const gl::Device& gl = tools_.device;
    const glm::ivec3 size(size_, count);
    const bool fine = format_ == Settings::Format::rgba32f;
    const GLenum format = fine ? GL_RGBA32F : GL_RGBA16F;  // those with an alpha
    bool made_anew = false;
    const auto make = [&](gl::Texture& texture, const char* label, bool wanted) {
        if (!wanted) {
            texture = {};
        } else if (texture.size() != size || fine != fine_splits_) {
            texture = gl::Texture::make_2d_array(gl, label, size, format, gl::Filter::linear);
            made_anew = true;
        }
    };
    make(split_scattering_, "split scattering", true);
    make(split_transmittance_, "split transmittance", !monochrome_);
    fine_splits_ = fine;
    if (panes == 0) {
        constexpr float kBeyond = 3e38f;
        std::fill(std::begin(split_params_.view_z), std::end(split_params_.view_z),
                  glm::vec4(kBeyond));
        split_params_.count = count;
        for (int k = 0; k < count; ++k)
            split_params_.view_z[k / 4][k % 4] = depths[static_cast<std::size_t>(k)];
        split_block_.write(split_params_);
        gl->BindBufferBase(GL_UNIFORM_BUFFER, SPLITS_BLOCK, split_block_.id());
    }
    clear_splits(made_anew);
    split_scattering_.bind_image(SPLIT_SCATTERING_IMAGE, GL_WRITE_ONLY);
    split_transmittance_.bind_image(SPLIT_TRANSMITTANCE_IMAGE, GL_WRITE_ONLY);
}

void RayMarch::clear_splits(bool made_anew)
{
    const std::vector<bool> now = tiles_.keeps_depths();
    bool stale = made_anew || now.size() != split_tiles_.size();
    for (std::size_t i = 0; i < now.size() && !stale; ++i)
        stale = split_tiles_[i] && !now[i];
    if (!stale) {
        std::transform(now.begin(), now.end(), split_tiles_.begin(), split_tiles_.begin(),
                       std::logical_or<>());
        return;
    }
    split_tiles_ = now;
    constexpr std::array<GLfloat, 4> kNothing{0, 0, 0, 1}, kAll{1, 1, 1, 1};
    split_scattering_.clear(GL_RGBA, GL_FLOAT, kNothing.data());
    if (split_transmittance_)
        split_transmittance_.clear(GL_RGBA, GL_FLOAT, kAll.data());
}

SplitLayers RayMarch::splits() const
{
    return {&split_scattering_, &split_transmittance_, &split_params_};
}

std::uint64_t RayMarch::split_bytes() const
{
    std::uint64_t texels = 0;
    for (const gl::Texture* texture : {&split_scattering_, &split_transmittance_})
        texels += static_cast<std::uint64_t>(texture->size().x) *
                  static_cast<std::uint64_t>(texture->size().y) *
                  static_cast<std::uint64_t>(texture->size().z);
    return texels * (fine_splits_ ? 16 : 8);
}

gl::Defines RayMarch::bind_split_layers(const FrameSettings& settings) const
{
    depth_.bind(LAYER_DEPTH_UNIT);
    split_scattering_.bind(SPLIT_SCATTERING_UNIT);
    split_transmittance_.bind(SPLIT_TRANSMITTANCE_UNIT);
    tools_.device->BindBufferBase(GL_UNIFORM_BUFFER, SPLITS_BLOCK, split_block_.id());
    gl::Defines defines{{"kLayerScale", fmt::format("{}", scale_)},
                        {"kSplitFours", fmt::format("{}", (settings.splits + 3) / 4)}};
    if (monochrome_)
        defines.emplace_back("kMonochrome", "");
    defines.add_file("written/volume_at.glsl",
                     "#include \"scene/volume_at_splits.glsl\"\n"
                     "#define VolumeRay SplitRay\n#define volume_ray split_ray\n");
    return defines;
}

void RayMarch::draw_layer_depth(const PreparedFrame& frame)
{
    resize(frame);
    {
        const auto time = tools_.timers.scope("step tiles");
        tiles_.set(frame);
    }
    const auto time = tools_.timers.scope("layer depth");
    // What is looked up before a depth reads rays that see no medium as well: none is short of it.
    constexpr GLfloat kFar = 3e38f;
    if (!frame.depths_asked.areas.empty())
        depth_.clear(GL_RED, GL_FLOAT, &kFar);
    gl::Defines defines{{"kLayerScale", fmt::format("{}", frame.settings.resolution)}};
    if (frame.settings.layer_depth == Settings::LayerDepth::checkerboard)
        defines.emplace_back("kCheckerboard", "");
    if (tiles_.computes())
        depth_.bind_image(LAYER_IMAGE, GL_WRITE_ONLY);
    else
        depth_framebuffer_.bind(size_);
    tiles_.run_depth("pass/layer_depth", defines);
    if (tiles_.computes())
        tools_.device->MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    depth_.bind(LAYER_DEPTH_UNIT);
    tools_.blue_noise.bind(BLUE_NOISE_UNIT);
}

void RayMarch::draw(const PreparedFrame& frame)
{
    tools_.check_loops(frame.settings.steps, frame.settings.shadow_steps);
    draw_layer_depth(frame);
    const auto time = tools_.timers.scope("ray march");
    resize_splits(frame);
    const gl::Device& gl = tools_.device;
    constexpr std::array<GLfloat, 4> kNothing{0, 0, 0, 1}, kAll{1, 1, 1, 1};
    gl->ClearNamedFramebufferfv(framebuffer_.id(), GL_COLOR, 0, kNothing.data());
    if (transmittance_)
        gl->ClearNamedFramebufferfv(framebuffer_.id(), GL_COLOR, 1, kAll.data());
    gl::Defines defines = march_defines(frame);
    if (has_media_depth_)
        defines.emplace_back("kMediaDepth", "");
    if (split_scattering_)
        defines.emplace_back("kSplits", "");
    if (frame.panes > 0)
        defines.emplace_back("kPanes", fmt::format("{}", frame.pane_places));
    if (frame.prepares && has_aureoles())
        march(framebuffer_, scattering_, transmittance_, defines);
    if (frame.prepares ? has_aureoles() : sees_aureole(frame))
        defines.emplace_back("kAureole", "");
    march(framebuffer_, scattering_, transmittance_, defines);
    if (tiles_.computes() || split_scattering_)  // for lookups
        gl->MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
}

void RayMarch::march(const gl::Framebuffer& framebuffer, const gl::Texture& first,
                     const gl::Texture& second, gl::Defines defines) const
{
    if (tiles_.computes()) {
        first.bind_image(LAYER_IMAGE, GL_WRITE_ONLY);
        second.bind_image(LAYER_MORE_IMAGE, GL_WRITE_ONLY);
        if (!second)
            defines.emplace_back("kOneTarget", "");
    } else {
        framebuffer.bind(size_);
    }
    tiles_.run_march(kMarch, defines);
}

MarchedLayer RayMarch::layer() const
{
    return {&tiles_, &depth_, &scattering_, &transmittance_, monochrome_, guard_, scale_};
}

gl::Texture RayMarch::sample_counts(const PreparedFrame& frame)
{
    draw_layer_depth(frame);
    const gl::Device& gl = tools_.device;
    gl::Texture counts =
        gl::Texture::make_2d(gl, "sample counts", size_, GL_R32F, gl::Filter::nearest);
    gl::Framebuffer framebuffer(gl, "sample counts");
    framebuffer.attach_color({counts.view()});
    constexpr std::array<GLfloat, 4> kNone{};
    gl->ClearNamedFramebufferfv(framebuffer.id(), GL_COLOR, 0, kNone.data());
    gl::Defines defines = march_defines(frame);
    defines.emplace_back("kCountSamples", "");
    march(framebuffer, counts, {}, defines);
    if (tiles_.computes())  // for who reads them back, or looks them up
        gl->MemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT);
    return counts;
}

void RayMarch::show_samples(const PreparedFrame& frame, const gl::Texture& counts)
{
    counts.bind(INSPECTED_UNIT);
    tools_.draw_fullscreen("pass/inspect_rays.frag",
                           {{"kLayerScale", fmt::format("{}", frame.settings.resolution)}});
}

}  // namespace fumarole::pass
