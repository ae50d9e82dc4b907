#include <fumarole/renderer.h>

#include <array>
#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>
#include <numeric>

#include "gl/framebuffer.h"
#include "gl/state_guard.h"
#include "explain.h"
#include "gl/timer.h"
#include "light/light_set.h"
#include "light/light_volumes.h"
#include "medium/media_set.h"
#include "prepared_frame.h"
#include "resolve/composite.h"
#include "resolve/inspect.h"
#include "resolve/layers.h"
#include "shared/bindings.h"
#include "surface/surface_painter.h"
#include "surface/surface_set.h"
#include "toolbox.h"
#include <fumarole/errors.h>

namespace fumarole {

namespace {

/// Of the pictures that prepare() draws, and the view that they are of.
constexpr glm::ivec2 kPreparedSize(16);
constexpr int kPreparedView = std::numeric_limits<int>::min();

void check(const Frame& frame)
{
    const glm::ivec2 color(frame.color.size), depth(frame.depth.size);
    if (!frame.color || !frame.depth || color != depth)
        throw Error(fmt::format("the frame's colour ({} x {}) and depth ({} x {}) must be textures "
                                "of one size",
                                color.x, color.y, depth.x, depth.y));
}

}  // namespace

struct Renderer::Parts {
    explicit Parts(gl::GetProc get_proc)
        : device{get_proc}, programs{device}, timers{device}, surfaces{device}, media{device},
          lights{device, programs}, volumes{device, programs, timers},
          fullscreen{device, "fullscreen"}, host{device, "host"}, frame_block{device, "frame"},
          depth_sampler{device, "scene depth"}, surface_painter{device}
    {
    }

    [[nodiscard]] int texture_units() const { return GRID_UNIT + media.texture_units(); }
    [[nodiscard]] FrameScene frame_scene() const;
    /// Settles a frame and binds what all passes read of it, the media and the lights too where it
    /// sees a medium.
    PreparedFrame begin(const Frame& frame, const Settings& s);
    resolve::Layers& layers_of(const Settings& s);

    gl::Device device;
    gl::ProgramCache programs;
    gl::PassTimers timers;
    surface::SurfaceSet surfaces;
    medium::MediaSet media;
    light::LightSet lights;
    light::LightVolumes volumes;
    gl::VertexArray fullscreen;
    gl::Framebuffer host;
    gl::UniformBuffer<shared::FrameParams> frame_block;
    gl::Sampler depth_sampler;  ///< so that the host's filter and comparison don't matter
    std::uint64_t scene_id = 0;
    bool prepares = false;  ///< while prepare() draws
    surface::SurfacePainter surface_painter;
    const Toolbox tools{device, programs,   timers,      media,        lights,
                        volumes, fullscreen, frame_block, depth_sampler};
    Settings::Mode mode = Settings::Mode::raymarch;  ///< of the layers
    std::unique_ptr<resolve::Layers> layers;
};

resolve::Layers& Renderer::Parts::layers_of(const Settings& s)
{
    if (layers != nullptr && mode == s.mode)
        return *layers;
    layers.reset();  // one mode's textures at a time
    mode = s.mode;
    layers = resolve::make_layers(mode, tools);
    return *layers;
}

FrameScene Renderer::Parts::frame_scene() const
{
    // A spot's beam has edges.
    const double detail = lights.spots() > 0 ? 0 : media.detail();
    return {media.bounds(), detail, static_cast<double>(media.traits().most_g), scene_id};
}

PreparedFrame Renderer::Parts::begin(const Frame& frame, const Settings& s)
{
    PreparedFrame view = prepare_frame(frame, s, frame_scene());
    view.prepares = prepares;
    tools.bind(view);
    if (!view.sees_media)
        return view;
    media.bind(view.eye.position);
    lights.bind(view.eye.position);
    const auto time = timers.scope("light volumes");
    volumes.bind(view.eye.position, view.eye.forward, view.eye.perspective, media);
    return view;
}

Renderer::Renderer(gl::GetProc get_proc) : parts_{std::make_unique<Parts>(get_proc)} {}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

void Renderer::set_scene(const Scene& scene, const Settings& settings)
{
    const gl::StateGuard guard(parts_->device, GRID_UNIT, BLOCK_COUNT, 0);
    ++parts_->scene_id;
    try {
        parts_->media.set(scene, settings);
        parts_->surfaces.set(scene.surfaces);
        parts_->lights.set(scene, parts_->surfaces, parts_->media.bounds(), settings.shadow_map,
                           parts_->media.traits().marched > 0);
        const gl::StateGuard all_units(parts_->device, parts_->texture_units(), BLOCK_COUNT,
                                       IMAGE_COUNT);
        parts_->volumes.set(scene, settings, parts_->media, parts_->surfaces, parts_->lights);
    } catch (...) {  // half a scene is none
        parts_->media.clear();
        parts_->surfaces.set({});
        parts_->lights.clear();
        parts_->volumes.clear();
        throw;
    }
}

Settings Renderer::settled(const Frame& frame, const Settings& settings) const
{
    return prepare_frame(frame, settings, parts_->frame_scene()).settings;
}

void Renderer::composite(const Frame& frame, const Settings& settings)
{
    check(frame);
    Parts& parts = *parts_;
    const auto timed = parts.timers.frame(frame.index);
    if (parts.media.empty())
        return;
    const gl::Device& gl = parts.device;
    const gl::StateGuard guard(gl, parts.texture_units(), BLOCK_COUNT, IMAGE_COUNT);
    const PreparedFrame view = parts.begin(frame, settings);
    if (!view.sees_media)
        return;
    parts.host.attach_color({frame.color});
    resolve::Layers& layers = parts.layers_of(view.settings);
    layers.draw(view);
    resolve::composite(parts.tools, layers, parts.host, view);
    gl->NamedFramebufferTexture(parts.host.id(), GL_COLOR_ATTACHMENT0, 0, 0);
    if (parts.volumes.has_more()) {
        const auto time = parts.timers.scope("light volumes, anew");
        parts.volumes.go_on(view.eye.position);
    }
}

InspectionLegend Renderer::inspect(const Frame& frame, const Settings& settings,
                                   const Inspection& inspection)
{
    check(frame);
    Parts& parts = *parts_;
    const auto timed = parts.timers.frame(frame.index);
    const gl::StateGuard guard(parts.device, parts.texture_units(), BLOCK_COUNT, IMAGE_COUNT);
    parts.host.attach_color({frame.color});
    const PreparedFrame view = parts.begin(frame, settings);
    InspectionLegend legend = resolve::inspect(parts.tools, parts.layers_of(view.settings),
                                               parts.host, view, inspection);
    parts.device->NamedFramebufferTexture(parts.host.id(), GL_COLOR_ATTACHMENT0, 0, 0);
    return legend;
}

LayerImages Renderer::read_layers(const Frame& frame, const Settings& settings)
{
    check(frame);
    Parts& parts = *parts_;
    const glm::ivec2 size(frame.color.size);
    const std::size_t pixels = static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y);
    LayerImages images{std::vector<float>(pixels * 3, 0.0f), std::vector<float>(pixels * 3, 1.0f)};
    if (parts.media.empty())
        return images;
    const gl::StateGuard guard(parts.device, parts.texture_units(), BLOCK_COUNT, IMAGE_COUNT);
    const PreparedFrame view = parts.begin(frame, settings);
    if (!view.sees_media)
        return images;
    const gl::Texture full = gl::Texture::make_2d(parts.device, "layer at full size", size,
                                                  GL_RGBA32F, gl::Filter::nearest);
    gl::Framebuffer framebuffer(parts.device, "layer at full size");
    framebuffer.attach_color({full.view()});
    framebuffer.bind(size);
    resolve::Layers& layers = parts.layers_of(view.settings);
    // Where no medium is in view nothing is drawn.
    constexpr std::array<GLfloat, 4> kNothing{0, 0, 0, 1}, kAll{1, 1, 1, 1};
    parts.device->ClearNamedFramebufferfv(framebuffer.id(), GL_COLOR, 0, kNothing.data());
    layers.resolve(view, resolve::Layer::scattering);
    const std::vector<float> scattering = full.read(4);
    const bool monochrome = parts.tools.monochrome(view.settings);
    if (!monochrome) {
        parts.device->ClearNamedFramebufferfv(framebuffer.id(), GL_COLOR, 0, kAll.data());
        layers.resolve(view, resolve::Layer::transmittance);
    }
    const std::vector<float> transmittance = monochrome ? scattering : full.read(4);
    for (std::size_t i = 0; i < pixels; ++i)
        for (std::size_t c = 0; c < 3; ++c) {
            images.scattering[i * 3 + c] = scattering[i * 4 + c];
            images.transmittance[i * 3 + c] = transmittance[i * 4 + (monochrome ? 3 : c)];
        }
    return images;
}

double Renderer::count_samples(const Frame& frame, const Settings& settings)
{
    check(frame);
    Parts& parts = *parts_;
    if (parts.media.empty())
        return 0;
    const gl::StateGuard guard(parts.device, parts.texture_units(), BLOCK_COUNT, IMAGE_COUNT);
    const PreparedFrame view = parts.begin(frame, settings);
    if (!view.sees_media)
        return 0;
    pass::VolumePass& pass = parts.layers_of(view.settings).pass();
    const std::vector<float> counts = pass.sample_counts(view).read(1);
    return std::accumulate(counts.begin(), counts.end(), 0.0);
}

void Renderer::reset_history(int view)
{
    if (parts_->layers != nullptr)
        parts_->layers->forget(view);
}

void Renderer::draw_surfaces(const Frame& frame, const Settings& settings, bool through_media)
{
    check(frame);
    Parts& parts = *parts_;
    const bool dimmed = through_media && settings.volume_shadows && !parts.media.empty() &&
                        parts.lights.count() > 0;
    const gl::StateGuard guard(parts.device, parts.texture_units(), BLOCK_COUNT, IMAGE_COUNT);
    const auto time = parts.timers.scope(through_media ? "surfaces through media" : "surfaces");
    const PreparedFrame view =
        prepare_frame(frame, surface::surface_settings(settings), parts.frame_scene());
    if (dimmed)
        parts.tools.check_loops(1, view.settings.shadow_steps, settings);
    parts.tools.bind_block(view);
    const Eye& eye = view.eye;
    parts.lights.bind(eye.position);
    if (dimmed) {
        parts.media.bind(eye.position);
        parts.volumes.bind(eye.position, eye.forward, eye.perspective, parts.media);
    }
    parts.volumes.bind_for_surfaces(eye.position, through_media);
    parts.surface_painter.draw(parts.tools, parts.surfaces, view, dimmed);
}

std::vector<std::string> Renderer::explain(const Settings& settings) const
{
    const auto surfaces = static_cast<int>(parts_->surfaces.instances().size());
    return fumarole::explain(parts_->tools, surfaces, settings);
}

const medium::MediaTraits& Renderer::media_traits() const
{
    return parts_->media.traits();
}

Bounds Renderer::media_bounds() const
{
    return parts_->media.bounds();
}

void Renderer::prepare(const Frame& frame, const Settings& settings)
{
    check(frame);
    Parts& parts = *parts_;
    const gl::Texture color = gl::Texture::make_2d(parts.device, "prepared picture", kPreparedSize,
                                                   GL_RGBA16F, gl::Filter::nearest);
    const gl::Texture depth = gl::Texture::make_2d(parts.device, "prepared depth", kPreparedSize,
                                                   GL_DEPTH_COMPONENT32F, gl::Filter::nearest);
    const Bounds media = parts.media.bounds();
    const Eye eye = prepare_frame(frame, settings, parts.frame_scene()).eye;
    // Amid the media, whatever the frame sees, and a little further: a view that has moved.
    const auto look_from = [&](double part) {
        glm::dvec3 p = eye.position;
        if (!media.empty())
            p = glm::mix(media.min, media.max, part) - eye.forward * eye.near;
        Frame small = frame;
        small.color = color.view();
        small.depth = depth.view();
        small.view_from_world = glm::translate(glm::dmat4(glm::transpose(eye.world_from_view)), -p);
        small.history = kPreparedView;
        return small;
    };
    Frame still = look_from(0.5), moved = look_from(0.51);
    for (const bool through_media : {false, true})
        draw_surfaces(still, settings, through_media);
    parts.prepares = true;
    std::vector<int> scales{settled(still, settings).resolution};
    if (settings.mode == Settings::Mode::raymarch && settings.resolution == Settings::kAutomatic)
        scales = {2, 4};
    for (const int scale : scales) {
        Settings s = settings;
        s.resolution = scale;
        for (Frame* one : {&still, &still, &moved}) {
            composite(*one, s);
            ++still.index;
            ++moved.index;
        }
        reset_history(kPreparedView);
    }
    parts.prepares = false;
}

void Renderer::wait_until_ready()
{
    if (parts_->lights.shaded_media())
        parts_->lights.wait_for_sun_shadows();
    parts_->device->Finish();
}

void Renderer::set_timing(Timing timing)
{
    parts_->timers.set_timing(timing);
}

Timing Renderer::timing() const
{
    return parts_->timers.timing();
}

Timing Renderer::measuring_timing() const
{
    return gl::measuring_timing(parts_->device);
}

FrameReport Renderer::take_report()
{
    FrameReport report;
    report.timing = parts_->timers.timing();
    if (auto times = parts_->timers.take()) {
        report.pass_ms = std::move(times->passes);
        report.timed_frame = times->index;
    }
    report.gpu_bytes = parts_->device.bytes();
    report.allocations = parts_->device.allocations();
    if (parts_->layers != nullptr)
        report.history = parts_->layers->history_use();
    return report;
}

const gl::Device& Renderer::device() const
{
    return parts_->device;
}

}  // namespace fumarole
