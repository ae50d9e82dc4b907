#include <fumarole/renderer.h>

#include <array>
#include <cmath>
#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>
#include <numeric>
#include <optional>

#include "gl/framebuffer.h"
#include "gl/state_guard.h"
#include "gl/timer.h"
#include "light/light_set.h"
#include "light/light_volumes.h"
#include "medium/media_set.h"
#include "pass/frame_setup.h"
#include "pass/froxels.h"
#include "pass/inspect.h"
#include "pass/ray_march.h"
#include "shared/bindings.h"
#include "surface/surface_set.h"
#include <fumarole/errors.h>

namespace fumarole {

namespace {

/// Of the pictures that prepare() draws, and the view that they are of.
constexpr glm::ivec2 kPreparedSize(16);
constexpr int kPreparedView = std::numeric_limits<int>::min();

/// A surface pixel shows one shadow ray where a ray's samples average many: it gets this many times
/// the steps. (Bands of 16 steps show in a smoke's shadow on the ground, bands of 64 do not.)
constexpr int kSurfaceShadowFactor = 4;

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
          draw_block{device, "surface draw"}, depth_sampler{device, "scene depth"}
    {
    }

    [[nodiscard]] int texture_units() const { return GRID_UNIT + media.texture_units(); }
    /// Sets up what all passes of a frame read. Nothing if no medium can be seen: nothing is drawn
    /// then.
    std::optional<pass::PassFrame> begin(const Frame& frame, const Settings& s);
    pass::PassFrame bind_frame(const Frame& frame, const Settings& s);
    /// @returns whether a medium can be seen; nothing is bound if not
    bool bind_media(const pass::PassFrame& view);
    pass::VolumePass& volume_pass(const Settings& s);
    void blend(const pass::PassFrame& frame, pass::Layer layer, const char* what);

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
    gl::UniformBuffer<shared::DrawParams> draw_block;
    gl::Sampler depth_sampler;  ///< so that the host's filter and comparison don't matter
    std::uint64_t scene_id = 0;
    bool marches = false;   ///< what set_scene() was told
    bool prepares = false;  ///< while prepare() draws
    const pass::Toolbox tools{device, programs, timers, media, lights, volumes, fullscreen};
    Settings::Mode mode = Settings::Mode::raymarch;  ///< of the pass
    std::unique_ptr<pass::VolumePass> pass;
};

pass::VolumePass& Renderer::Parts::volume_pass(const Settings& s)
{
    if (pass != nullptr && mode == s.mode)
        return *pass;
    pass.reset();  // one mode's textures at a time
    mode = s.mode;
    if (mode == Settings::Mode::froxel)
        pass = std::make_unique<pass::Froxels>(tools);
    else
        pass = std::make_unique<pass::RayMarch>(tools);
    return *pass;
}

pass::PassFrame Renderer::Parts::bind_frame(const Frame& frame, const Settings& s)
{
    const pass::PassFrame view{frame, s, pass::make_eye(frame), media.bounds(), scene_id, prepares};
    frame_block.write(pass::make_frame_params(frame, view.eye, view.media, s));
    device->BindBufferBase(GL_UNIFORM_BUFFER, FRAME_BLOCK, frame_block.id());
    gl::bind_texture(device, SCENE_DEPTH_UNIT, frame.depth);
    device->BindSampler(SCENE_DEPTH_UNIT, depth_sampler.id());
    return view;
}

bool Renderer::Parts::bind_media(const pass::PassFrame& view)
{
    // 2017 marched whatever the view: its floor under the extinction is everywhere.
    const bool everywhere = view.settings.range == Settings::Range::camera;
    if (media.empty() ||
        (!everywhere && pass::view_z_range(view.eye, view.media).y <= view.eye.near))
        return false;
    media.bind(view.eye.position);
    lights.bind(view.eye.position);
    const auto time = timers.scope("light volumes");
    volumes.bind(view.eye.position, view.eye.forward, view.eye.perspective, media);
    return true;
}

std::optional<pass::PassFrame> Renderer::Parts::begin(const Frame& frame, const Settings& s)
{
    const pass::PassFrame view = bind_frame(frame, s);
    if (!bind_media(view))
        return std::nullopt;
    return view;
}

void Renderer::Parts::blend(const pass::PassFrame& frame, pass::Layer layer, const char* what)
{
    const auto time = timers.scope(fmt::format("{} {}", pass->resolve_name(), what));
    pass->resolve(frame, layer);
}

Renderer::Renderer(gl::GetProc get_proc) : parts_{std::make_unique<Parts>(get_proc)} {}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

void Renderer::set_scene(const Scene& scene, const Settings& settings)
{
    const gl::StateGuard guard(parts_->device, GRID_UNIT, BLOCK_COUNT, 0);
    ++parts_->scene_id;
    parts_->marches = settings.mode == Settings::Mode::raymarch;
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
    Settings s = settings;
    if (s.resolution != Settings::kAutomatic)
        return s;
    if (s.mode == Settings::Mode::froxel) {  // not its, and no reason to drop a history
        s.resolution = 1;
        return s;
    }
    if (pass::keeps_history(frame, s)) {  // lost whenever the layer's size changed
        s.resolution = 2;
        return s;
    }
    // A spot's beam has edges.
    const double detail = parts_->lights.spots() > 0 ? 0 : parts_->media.detail();
    s.resolution = pass::layer_scale(frame, pass::make_eye(frame), parts_->media.bounds(), detail,
                                     static_cast<double>(parts_->media.traits().most_g));
    return s;
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
    const Settings s = settled(frame, settings);
    const auto view = parts.begin(frame, s);
    if (!view)
        return;
    parts.host.attach_color({frame.color});
    parts.volume_pass(s).draw(*view);

    parts.host.bind(glm::ivec2(frame.color.size));
    gl->Enablei(GL_BLEND, 0);
    gl->BlendEquationi(0, GL_FUNC_ADD);
    gl->ColorMaski(0, GL_TRUE, GL_TRUE, GL_TRUE, GL_FALSE);
    if (parts.tools.monochrome(s)) {
        gl->BlendFunci(0, GL_ONE, GL_SRC_ALPHA);
        parts.blend(*view, pass::Layer::scattering, "both");
    } else if (s.resolve_passes == 1) {
        gl->BlendFunci(0, GL_ONE, GL_SRC1_COLOR);
        parts.blend(*view, pass::Layer::both, "both");
    } else {
        gl->BlendFunci(0, GL_ZERO, GL_SRC_COLOR);
        parts.blend(*view, pass::Layer::transmittance, "transmittance");
        gl->BlendFunci(0, GL_ONE, GL_ONE);
        parts.blend(*view, pass::Layer::scattering, "scattering");
    }
    gl->NamedFramebufferTexture(parts.host.id(), GL_COLOR_ATTACHMENT0, 0, 0);
    if (parts.volumes.has_more()) {
        const auto time = parts.timers.scope("light volumes, anew");
        parts.volumes.go_on(view->eye.position);
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
    const Settings s = settled(frame, settings);
    const pass::PassFrame view = parts.bind_frame(frame, s);
    const bool sees_media = parts.bind_media(view);
    InspectionLegend legend =
        pass::inspect(parts.tools, parts.volume_pass(s), parts.host, view, sees_media, inspection);
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
    const Settings s = settled(frame, settings);
    const auto view = parts.begin(frame, s);
    if (!view)
        return images;
    const gl::Texture full = gl::Texture::make_2d(parts.device, "layer at full size", size,
                                                  GL_RGBA32F, gl::Filter::nearest);
    gl::Framebuffer framebuffer(parts.device, "layer at full size");
    framebuffer.attach_color({full.view()});
    framebuffer.bind(size);
    pass::VolumePass& pass = parts.volume_pass(s);
    // Where no medium is in view nothing is drawn.
    constexpr std::array<GLfloat, 4> kNothing{0, 0, 0, 1}, kAll{1, 1, 1, 1};
    parts.device->ClearNamedFramebufferfv(framebuffer.id(), GL_COLOR, 0, kNothing.data());
    pass.resolve(*view, pass::Layer::scattering);
    const std::vector<float> scattering = full.read(4);
    const bool monochrome = parts.tools.monochrome(s);
    if (!monochrome) {
        parts.device->ClearNamedFramebufferfv(framebuffer.id(), GL_COLOR, 0, kAll.data());
        pass.resolve(*view, pass::Layer::transmittance);
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
    const Settings s = settled(frame, settings);
    const auto view = parts.begin(frame, s);
    if (!view)
        return 0;
    const std::vector<float> counts = parts.volume_pass(s).sample_counts(*view).read(1);
    return std::accumulate(counts.begin(), counts.end(), 0.0);
}

void Renderer::reset_history(int view)
{
    if (parts_->pass != nullptr)
        parts_->pass->forget(view);
}

void Renderer::draw_surfaces(const Frame& frame, const Settings& settings, bool through_media)
{
    check(frame);
    Parts& parts = *parts_;
    const gl::Device& gl = parts.device;
    const bool dimmed = through_media && settings.volume_shadows && !parts.media.empty() &&
                        parts.lights.count() > 0;
    const gl::StateGuard guard(gl, parts.texture_units(), BLOCK_COUNT, IMAGE_COUNT);
    const auto time = parts.timers.scope(through_media ? "surfaces through media" : "surfaces");
    const pass::Eye eye = pass::make_eye(frame);
    Settings surface_settings = settings;
    surface_settings.shadow_steps *= kSurfaceShadowFactor;
    surface_settings.resolution = 1;  // no layer is theirs
    if (dimmed)
        parts.tools.check_loops(1, surface_settings.shadow_steps, settings);
    parts.frame_block.write(
        pass::make_frame_params(frame, eye, parts.media.bounds(), surface_settings));
    gl->BindBufferBase(GL_UNIFORM_BUFFER, FRAME_BLOCK, parts.frame_block.id());
    gl->BindBufferBase(GL_UNIFORM_BUFFER, DRAW_BLOCK, parts.draw_block.id());
    parts.lights.bind(eye.position);
    if (dimmed) {
        parts.media.bind(eye.position);
        parts.volumes.bind(eye.position, eye.forward, eye.perspective, parts.media);
    }
    parts.volumes.bind_for_surfaces(eye.position, through_media);

    const bool reversed = frame.depth_convention.reversed;
    parts.host.attach_color({frame.color});
    parts.host.attach_depth(frame.depth);
    parts.host.bind(glm::ivec2(frame.color.size));
    gl->ClipControl(GL_LOWER_LEFT,
                    frame.depth_convention.zero_to_one ? GL_ZERO_TO_ONE : GL_NEGATIVE_ONE_TO_ONE);
    gl->DepthMask(GL_TRUE);
    const GLfloat sky = reversed ? 0.0f : 1.0f;
    gl->ClearNamedFramebufferfv(parts.host.id(), GL_DEPTH, 0, &sky);

    gl::Defines defines = parts.lights.defines();
    if (parts.lights.has_environment()) {
        defines.emplace_back("ENVIRONMENT", "");
        parts.lights.bind_environment();
    }
    parts.tools.draw_fullscreen("pass/sky.frag", defines);

    if (parts.lights.has_environment())
        parts.lights.bind_irradiance();
    const gl::Defines of_world = parts.volumes.surface_defines(settings);
    defines.insert(defines.end(), of_world.begin(), of_world.end());
    if (dimmed) {
        for (const gl::Defines& more : {parts.media.defines(), parts.volumes.defines(settings)})
            defines.insert(defines.end(), more.begin(), more.end());
        defines.emplace_back("THROUGH_MEDIA", "");
        if (settings.shadow_range == Settings::ShadowRange::light)
            defines.emplace_back("SHADOW_TO_LIGHT", "");
    }
    gl->Enable(GL_DEPTH_TEST);
    gl->DepthFunc(reversed ? GL_GREATER : GL_LESS);
    const glm::dmat4 view_from_eye(glm::transpose(eye.world_from_view));
    for (const auto& instance : parts.surfaces.instances()) {
        gl::Defines own = defines;
        if (!instance.closed)
            own.emplace_back("TWO_SIDED", "");
        gl->UseProgram(parts.programs.get({"pass/surface.vert", "pass/surface.frag"}, own).id());
        shared::DrawParams params{};
        const glm::dmat4 eye_from_object =
            glm::translate(glm::dmat4(1.0), -eye.position) * instance.world_from_object;
        params.clip_from_object = glm::mat4(frame.clip_from_view * view_from_eye * eye_from_object);
        params.world_from_object = glm::mat4(eye_from_object);
        params.albedo = glm::vec4(instance.albedo, 1.0f);
        parts.draw_block.write(params);
        parts.surfaces.draw(instance);
    }
    gl->NamedFramebufferTexture(parts.host.id(), GL_COLOR_ATTACHMENT0, 0, 0);
    gl->NamedFramebufferTexture(parts.host.id(), GL_DEPTH_ATTACHMENT, 0, 0);
}

std::vector<std::string> Renderer::explain(const Settings& settings) const
{
    const Parts& parts = *parts_;
    const medium::MediaTraits& media = parts.media.traits();
    std::vector<std::string> lines;
    const auto say = [&]<typename... T>(fmt::format_string<T...> text, T&&... arguments) {
        lines.push_back(fmt::format(text, std::forward<T>(arguments)...));
    };
    if (media.media == 0) {
        say("no medium scatters, absorbs or emits: nothing is drawn, the picture keeps its bits");
        return lines;
    }
    say("media: {}, of which {} change from place to place; others need no fetch and no shadow "
        "steps",
        media.media, media.heterogeneous);
    const bool froxel = settings.mode == Settings::Mode::froxel;
    if (froxel)
        for (const std::string& line : pass::explain_froxels(parts.tools, settings))
            lines.push_back(line);
    else if (parts.tools.monochrome(settings))
        say("extinction: {}: transmittance rides in the alpha of one target, one upsample instead "
            "of two",
            media.colored_extinction ? "coloured, but its mean was asked for" : "grey");
    else
        say("extinction: {}: a target of its own for transmittance, {}",
            media.colored_extinction ? "coloured" : "grey, but two targets were asked for",
            settings.resolve_passes == 1 ? "blended at once with the scattering" : "two upsamples");
    if (!froxel && pass::march_format(parts.tools, settings) != settings.format)
        say("target format: rgba16f, since r11g11b10f has no alpha");
    if (!froxel)
        say("resolution: {}",
            settings.resolution == 1   ? "full"
            : settings.resolution == 2 ? "half"
            : settings.resolution == 4
                ? "a quarter"
                : "half, or a quarter where a texel of that spans little of what the media, and "
                  "the light that they scatter, change within");
    if (!froxel && settings.keeps_history())
        say("history: a view's layer is reprojected and weighs {} while the view moves, and is the "
            "mean of all frames while it stands; a frame of no view has none",
            settings.history);
    say("phase: {}", media.isotropic ? "g is 0 everywhere: a constant, no angle is worked out"
                     : media.mixed_g
                         ? "media differ in g: its mean, weighted by sigma_s, per sample"
                         : "one g for all media");
    say("emission: {}", media.emission ? "yes" : "none: no fetch");
    if (parts.lights.count() == 0)
        say("lights: none: no loop over lights, no shadows");
    else
        say("lights: {} sun, {} point, {} spot", parts.lights.suns(), parts.lights.points(),
            parts.lights.spots());
    if (parts.lights.count() > 0 && parts.lights.shadow_views() == 0)
        say("surfaces: none that could hide a light: no shadow map, no lookup");
    else if (parts.lights.count() > 0)
        say("surfaces: {} in {} views of the shadow map, {}", parts.surfaces.instances().size(),
            parts.lights.shadow_views(),
            froxel || !settings.skip || settings.range == Settings::Range::camera
                ? "looked up at each sample"
            : !parts.lights.shaded_media()
                ? "but none can stand between a light and the media: no lookup"
                : "looked up where tiles are not lit all along");
    if (parts.lights.count() > 0) {
        if (!settings.volume_shadows)
            say("light through media: undimmed, as asked");
        else if (froxel && settings.froxel_shadows == Settings::FroxelShadows::grid)
            say("light through media: {} steps a froxel and light through the V-buffer; what is "
                "out "
                "of view throws no shadow",
                settings.shadow_steps);
        else if (media.heterogeneous == 0)
            say("light through media: closed form, no marching: all media are homogeneous");
        else if (parts.volumes.has_depth())
            say("light through media: from a volume for marched media; closed form where a medium "
                "is homogeneous or falls off with height");
        else
            say("light through media: {} steps a sample, light and marched medium; closed form "
                "where "
                "a medium is homogeneous or falls off with height",
                settings.shadow_steps);
    }
    const bool world = parts.lights.world_radiance() != glm::vec3(0.0f);
    say("world: {}", !world ? "black: no ambient term"
                     : parts.volumes.has_world()
                         ? "scatters from all around, dimmed by media and hidden by surfaces"
                     : settings.world_light ? "its mean radiance scatters, isotropic and undimmed"
                                            : "left out of the media, as asked");
    for (const auto& more : {parts.volumes.describe(), parts.media.describe()})
        lines.insert(lines.end(), more.begin(), more.end());
    return lines;
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
    const pass::Eye eye = pass::make_eye(frame);
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
    if (parts_->marches && parts_->lights.shaded_media())
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
    if (parts_->pass != nullptr)
        report.history = parts_->pass->history_use();
    return report;
}

const gl::Device& Renderer::device() const
{
    return parts_->device;
}

}  // namespace fumarole
