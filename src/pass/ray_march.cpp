#include "pass/ray_march.h"

#include <array>
#include <fmt/format.h>

#include "pass/layer_format.h"
#include "shared/bindings.h"

namespace fumarole::pass {

namespace {

constexpr const char* kMarch = "pass/ray_march.frag";

}  // namespace

Settings::Format march_format(const Toolbox& tools, const FrameSettings& s)
{
    const bool small = s.format == Settings::Format::r11g11b10f;
    return (tools.monochrome(s) || s.keeps_history()) && small ? Settings::Format::rgba16f
                                                               : s.format;
}

gl::Defines RayMarch::march_defines(const FrameSettings& s) const
{
    gl::Defines defines = tools_.scattering_defines(s);
    const auto add = [&](bool condition, const char* name) {
        if (condition)
            defines.emplace_back(name, "");
    };
    add(s.jitter == Settings::Jitter::blue, "kBlueNoise");
    add(s.range == Settings::Range::camera, "kCameraRange");
    add(tools_.monochrome(s), "kMonochrome");
    add(s.falloff == Settings::Falloff::exact, "kExactFalloff");
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

void RayMarch::draw_layer_depth(const PreparedFrame& frame)
{
    resize(frame);
    {
        const auto time = tools_.timers.scope("step tiles");
        tiles_.set(frame);
    }
    const auto time = tools_.timers.scope("layer depth");
    gl::Defines defines{{"kLayerScale", fmt::format("{}", frame.settings.resolution)}};
    if (frame.settings.layer_depth == Settings::LayerDepth::checkerboard)
        defines.emplace_back("kCheckerboard", "");
    depth_framebuffer_.bind(size_);
    tiles_.draw_depth("pass/layer_depth.frag", defines);
    depth_.bind(LAYER_DEPTH_UNIT);
    tools_.blue_noise.bind(BLUE_NOISE_UNIT);
}

void RayMarch::draw(const PreparedFrame& frame)
{
    tools_.check_loops(frame.settings.steps, frame.settings.shadow_steps);
    draw_layer_depth(frame);
    const auto time = tools_.timers.scope("ray march");
    framebuffer_.bind(size_);
    const gl::Device& gl = tools_.device;
    constexpr std::array<GLfloat, 4> kNothing{0, 0, 0, 1}, kAll{1, 1, 1, 1};
    gl->ClearNamedFramebufferfv(framebuffer_.id(), GL_COLOR, 0, kNothing.data());
    if (transmittance_)
        gl->ClearNamedFramebufferfv(framebuffer_.id(), GL_COLOR, 1, kAll.data());
    gl::Defines defines = march_defines(frame.settings);
    if (has_media_depth_)
        defines.emplace_back("kMediaDepth", "");
    tiles_.draw_march(kMarch, defines);
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
    framebuffer.bind(size_);
    constexpr std::array<GLfloat, 4> kNone{};
    gl->ClearNamedFramebufferfv(framebuffer.id(), GL_COLOR, 0, kNone.data());
    gl::Defines defines = march_defines(frame.settings);
    defines.emplace_back("kCountSamples", "");
    tiles_.draw_march(kMarch, defines);
    return counts;
}

void RayMarch::show_samples(const PreparedFrame& frame, const gl::Texture& counts)
{
    counts.bind(INSPECTED_UNIT);
    tools_.draw_fullscreen("pass/inspect_rays.frag",
                           {{"kLayerScale", fmt::format("{}", frame.settings.resolution)}});
}

}  // namespace fumarole::pass
