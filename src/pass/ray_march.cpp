#include "pass/ray_march.h"

#include <array>
#include <fmt/format.h>

#include "pass/blue_noise.h"
#include "shared/bindings.h"

namespace fumarole::pass {

namespace {

constexpr const char* kMarch = "pass/ray_march.frag";

gl::Defines upsample_defines(const Settings& s)
{
    const bool small = s.upsample == Settings::Upsample::bilinear2x2;
    gl::Defines defines{{"LAYER_SCALE", fmt::format("{}", s.resolution)},
                        {"UPSAMPLE_TAPS", s.resolution == 1 ? "1" : (small ? "2" : "4")}};
    if (s.upsample == Settings::Upsample::box4x4)
        defines.emplace_back("BOX_2017", "");
    return defines;
}

}  // namespace

Settings::Format march_format(const Toolbox& tools, const Settings& s)
{
    const bool small = s.format == Settings::Format::r11g11b10f;
    return (tools.monochrome(s) || s.keeps_history()) && small ? Settings::Format::rgba16f
                                                               : s.format;
}

RayMarch::RayMarch(const Toolbox& tools) : VolumePass{tools}, tiles_{tools}
{
    blue_noise_ = gl::Texture::make_2d(tools_.device, "blue noise", glm::ivec2(kBlueNoiseSize),
                                       GL_R32F, gl::Filter::nearest);
    std::vector<float> offsets;
    for (std::uint16_t rank : kBlueNoise)
        offsets.push_back((static_cast<float>(rank) + 0.5f) /
                          static_cast<float>(kBlueNoise.size()));
    blue_noise_.upload(GL_RED, GL_FLOAT, offsets.data());
}

gl::Defines RayMarch::march_defines(const Settings& s) const
{
    gl::Defines defines = tools_.scattering_defines(s);
    const auto add = [&](bool condition, const char* name) {
        if (condition)
            defines.emplace_back(name, "");
    };
    add(s.jitter == Settings::Jitter::blue, "BLUE_NOISE");
    add(s.range == Settings::Range::camera, "CAMERA_RANGE");
    add(tools_.monochrome(s), "MONOCHROME");
    add(s.falloff == Settings::Falloff::exact, "EXACT_FALLOFF");
    defines.emplace_back("LAYER_SCALE", fmt::format("{}", s.resolution));
    return defines;
}

void RayMarch::resize(const PassFrame& frame)
{
    const gl::Device& gl = tools_.device;
    const glm::ivec2 texels = layer_size(glm::ivec2(frame.host.color.size), frame.settings);
    const Settings::Format format = march_format(tools_, frame.settings);
    const bool monochrome = tools_.monochrome(frame.settings);
    const bool media_depth = keeps_history(frame.host, frame.settings);
    if (texels == size_ && format == format_ && monochrome == monochrome_ &&
        media_depth == has_media_depth_)
        return;
    size_ = texels;
    format_ = format;
    monochrome_ = monochrome;
    has_media_depth_ = media_depth;
    const GLenum color = gl_format(format);
    depth_ = gl::Texture::make_2d(gl, "layer depth", texels, GL_R32F, gl::Filter::nearest);
    scattering_ = gl::Texture::make_2d(gl, "layer scattering", texels, color, gl::Filter::nearest);
    transmittance_ = {};
    depth_framebuffer_ = {gl, "layer depth"};
    depth_framebuffer_.attach_color({depth_.view()});
    framebuffer_ = {gl, "layer"};
    if (!monochrome)
        transmittance_ =
            gl::Texture::make_2d(gl, "layer transmittance", texels, color, gl::Filter::nearest);
    else if (media_depth)
        transmittance_ =
            gl::Texture::make_2d(gl, "layer media depth", texels, GL_RG32F, gl::Filter::nearest);
    if (transmittance_)
        framebuffer_.attach_color({scattering_.view(), transmittance_.view()});
    else
        framebuffer_.attach_color({scattering_.view()});
}

void RayMarch::draw_layer_depth(const PassFrame& frame)
{
    resize(frame);
    {
        const auto time = tools_.timers.scope("step tiles");
        tiles_.set(frame);
    }
    const auto time = tools_.timers.scope("layer depth");
    gl::Defines defines{{"LAYER_SCALE", fmt::format("{}", frame.settings.resolution)}};
    if (frame.settings.layer_depth == Settings::LayerDepth::checkerboard)
        defines.emplace_back("CHECKERBOARD", "");
    depth_framebuffer_.bind(size_);
    tiles_.draw_depth("pass/layer_depth.frag", defines);
    depth_.bind(LAYER_DEPTH_UNIT);
    blue_noise_.bind(BLUE_NOISE_UNIT);
}

void RayMarch::march(const PassFrame& frame)
{
    tools_.check_loops(frame.settings.steps, frame.settings.shadow_steps, frame.settings);
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
        defines.emplace_back("MEDIA_DEPTH", "");
    tiles_.draw_march(kMarch, defines);
}

void RayMarch::draw(const PassFrame& frame)
{
    if (!frame.settings.keeps_history())
        history_.reset();
    march(frame);
    if (!keeps_history(frame.host, frame.settings))
        return;
    if (!history_)
        history_.emplace(tools_);
    history_->add(frame, tiles_, scattering_, transmittance_);
}

void RayMarch::forget(int view)
{
    if (history_)
        history_->forget(view);
}

std::string RayMarch::history_use() const
{
    return history_ ? to_string(history_->use()) : "";
}

void RayMarch::resolve(const PassFrame& frame, Layer layer)
{
    resize(frame);
    gl::Defines defines = upsample_defines(frame.settings);
    depth_.bind(LAYER_DEPTH_UNIT);
    const bool averaged = has_media_depth_ && history_;
    const MarchHistory::Layer* mean = averaged ? history_->find(frame.host.history) : nullptr;
    const gl::Texture& scattering = mean != nullptr ? mean->scattering : scattering_;
    const gl::Texture& transmittance = mean != nullptr ? mean->more : transmittance_;
    (layer == Layer::transmittance ? transmittance : scattering).bind(SCATTERING_UNIT);
    if (layer == Layer::both) {
        transmittance.bind(TRANSMITTANCE_UNIT);
        defines.emplace_back("BOTH", "");
    }
    tiles_.draw_picture("resolve/upsample.frag", defines);
}

gl::Texture RayMarch::sample_counts(const PassFrame& frame)
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
    defines.emplace_back("COUNT_SAMPLES", "");
    tiles_.draw_march(kMarch, defines);
    return counts;
}

void RayMarch::show_samples(const PassFrame& frame, const gl::Texture& counts)
{
    counts.bind(INSPECTED_UNIT);
    tools_.draw_fullscreen("pass/inspect_rays.frag",
                           {{"LAYER_SCALE", fmt::format("{}", frame.settings.resolution)}});
}

}  // namespace fumarole::pass
