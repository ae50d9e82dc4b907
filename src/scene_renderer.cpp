#include <fumarole/scene_renderer.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>
#include <map>

#include "gl/texture.h"
#include "halton.h"
#include <fumarole/errors.h>

namespace fumarole {

namespace {

/// The mean of several pictures, rows turned to come from the top.
class Mean {
public:
    Mean(int width, int height, int channels)
        : width_{static_cast<std::size_t>(width)}, height_{static_cast<std::size_t>(height)},
          channels_{static_cast<std::size_t>(channels)}, sum_(width_ * height_ * channels_)
    {
    }

    /// `from` may have more channels; the first ones are taken.
    void add(const std::vector<float>& from)
    {
        const std::size_t stride = from.size() / (width_ * height_);
        for (std::size_t y = 0; y < height_; ++y)
            for (std::size_t x = 0; x < width_; ++x)
                for (std::size_t c = 0; c < channels_; ++c)
                    sum_[((height_ - 1 - y) * width_ + x) * channels_ + c] +=
                        from[(y * width_ + x) * stride + c];
        ++count_;
    }

    [[nodiscard]] std::vector<float> get() const
    {
        std::vector<float> mean;
        mean.reserve(sum_.size());
        for (double s : sum_)
            mean.push_back(static_cast<float>(s / count_));
        return mean;
    }

private:
    std::size_t width_, height_, channels_;
    std::vector<double> sum_;
    int count_ = 0;
};

/// Halton's bases 2 and 3, over -0.5..0.5; point 0 is the middle.
glm::dvec2 layer_offset(std::uint64_t i)
{
    return glm::fract(glm::dvec2(radical_inverse(i, 2), radical_inverse(i, 3)) + 0.5) - 0.5;
}

/// view_z [m] of our own reversed depth, rows from the top.
std::vector<float> view_depth(const Frame& frame, const std::vector<float>& window_depth)
{
    const glm::dmat4& p = frame.clip_from_view;
    std::vector<float> view_z;
    view_z.reserve(window_depth.size());
    for (const double n : window_depth)
        view_z.push_back(
            n == 0 ? Still::kSkyDepth
                   : static_cast<float>((p[3][3] * n - p[3][2]) / (p[2][3] * n - p[2][2])));
    Mean one(frame.depth.size.x, frame.depth.size.y, 1);
    one.add(view_z);
    return one.get();
}

/// RGBA of Still::foreground for one frame.
std::vector<float> without_sky(const LayerImages& layers, const std::vector<float>& lit,
                               const std::vector<float>& window_depth)
{
    std::vector<float> rgba;
    for (std::size_t i = 0; i < window_depth.size(); ++i) {
        const bool sky = window_depth[i] == 0;
        float alpha = 0;
        for (std::size_t c = 0; c < 3; ++c) {
            const float through = layers.transmittance[i * 3 + c];
            rgba.push_back(layers.scattering[i * 3 + c] + (sky ? 0.0f : through * lit[i * 4 + c]));
            alpha += (sky ? 1.0f - through : 1.0f) / 3.0f;
        }
        rgba.push_back(alpha);
    }
    return rgba;
}

/// What the volume adds to a frame: its own passes, and what the media add to the surfaces'
/// shading.
double volume_ms(const std::vector<std::pair<std::string, double>>& passes)
{
    double volume = 0, clear = 0, through = 0;
    for (const auto& [name, ms] : passes) {
        if (name == "surfaces")
            clear = ms;
        else if (name == "surfaces through media")
            through = ms;
        else
            volume += ms;
    }
    return volume + std::max(0.0, through - clear);
}

void check_size(glm::ivec2 size, const gl::Device& gl)
{
    const int limit = gl.capabilities().max_texture_2d;
    if (size.x > limit || size.y > limit)
        throw Error(fmt::format("a picture of {} x {} is larger than this GL draws ({} at most); "
                                "give a smaller Scene::resolution",
                                size.x, size.y, limit));
}

/// Where a scene is drawn, and the frame that lends it.
struct Canvas {
    Canvas(const gl::Device& gl, const Scene& scene)
        : color{gl::Texture::make_2d(gl, "picture", glm::ivec2(scene.resolution), GL_RGBA32F,
                                     gl::Filter::nearest)},
          depth{gl::Texture::make_2d(gl, "picture depth", glm::ivec2(scene.resolution),
                                     GL_DEPTH_COMPONENT32F, gl::Filter::nearest)}
    {
    }

    /// Frame i of those that are averaged, a picture of its own.
    [[nodiscard]] Frame frame(const Camera& camera, const FrameSettings& settings, int i,
                              std::uint32_t seed) const
    {
        return still_frame(camera, settings, color.view(), depth.view(), i, seed);
    }

    gl::Texture color, depth;
};

/// While it lives the renderer measures by waiting, so that explain() says what its volumes took.
class Measured {
public:
    explicit Measured(Renderer& renderer) : renderer_{renderer}, before_{renderer.timing()}
    {
        renderer_.set_timing(Timing::finish);
    }
    ~Measured() { renderer_.set_timing(before_); }
    Measured(const Measured&) = delete;
    Measured& operator=(const Measured&) = delete;

private:
    Renderer& renderer_;
    Timing before_;
};

}  // namespace

PassTime summarize(std::string name, std::vector<double> ms)
{
    if (ms.empty())
        return {std::move(name)};
    std::sort(ms.begin(), ms.end());
    const std::size_t n = ms.size();
    return {std::move(name), ms.front(), (ms[(n - 1) / 2] + ms[n / 2]) / 2, ms.back()};
}

glm::dvec2 subpixel_offset(int i)
{
    // R2 of Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences": steps by the
    // powers of 1 / 1.3247..., the plastic number.
    constexpr double kA1 = 0.7548776662466927;
    constexpr double kA2 = 0.5698402909980532;
    const glm::dvec2 p = glm::fract(glm::dvec2(0.5 + kA1 * i, 0.5 + kA2 * i));
    return p - 0.5;
}

glm::dmat4 view_from_world(const Camera& camera)
{
    return glm::lookAt(camera.position, camera.look_at, camera.up);
}

glm::dmat4 clip_from_view(const Camera& camera, glm::uvec2 size, glm::dvec2 offset)
{
    const double aspect = static_cast<double>(size.x) / size.y;
    const double tangent = std::tan(glm::radians(camera.vfov_deg) / 2);
    const double near = camera.near, far = camera.far;
    glm::dmat4 p(0.0);
    if (camera.projection == Camera::Projection::perspective) {
        p[0][0] = 1 / (tangent * aspect);
        p[1][1] = 1 / tangent;
        p[2][2] = near / (far - near);
        p[2][3] = -1;
        p[3][2] = far * near / (far - near);
    } else {
        const double half = camera.ortho_height > 0
                                ? camera.ortho_height / 2
                                : tangent * glm::length(camera.look_at - camera.position);
        p[0][0] = 1 / (half * aspect);
        p[1][1] = 1 / half;
        p[2][2] = 1 / (far - near);
        p[3][2] = far / (far - near);
        p[3][3] = 1;
    }
    const glm::dvec3 shift(-2 * offset.x / size.x, -2 * offset.y / size.y, 0);
    return glm::translate(glm::dmat4(1.0), shift) * p;
}

Frame still_frame(const Camera& camera, const FrameSettings& settings, gl::TextureView color,
                  gl::TextureView depth, int i, std::uint32_t seed)
{
    Frame frame;
    frame.color = color;
    frame.depth = depth;
    frame.depth_convention = {.zero_to_one = true, .reversed = true};
    frame.view_from_world = view_from_world(camera);
    frame.clip_from_view = clip_from_view(camera, glm::uvec2(color.size), subpixel_offset(i));
    frame.layer_offset =
        settings.resolution != 1 ? layer_offset(static_cast<std::uint64_t>(i)) : glm::dvec2(0);
    frame.jitter_offset = golden_fraction(i + 1024.0 * seed);
    frame.index = static_cast<std::uint64_t>(i) + 1024ull * seed;
    return frame;
}

double SceneRenderer::set_scene(const Scene& scene, const SceneSettings& settings)
{
    if (held_ && held_->second == settings && same_content(held_->first, scene))
        return 0;
    const auto begin = std::chrono::steady_clock::now();
    held_.reset();
    {
        const Measured measured(renderer_);
        renderer_.set_scene(scene, settings);
    }
    renderer_.wait_until_ready();
    held_.emplace(scene, settings);
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
        .count();
}

FrameReport SceneRenderer::timed_report()
{
    renderer_.wait_until_ready();
    return renderer_.take_report();
}

Settings SceneRenderer::settled(const Scene& scene, const Settings& settings)
{
    set_scene(scene, settings);
    const gl::TextureView picture{0, glm::ivec3(scene.resolution, 1)};
    const Frame frame = still_frame(scene.camera, settings, picture, picture, 0, 0);
    Settings settled = settings;
    static_cast<FrameSettings&>(settled) = renderer_.settled(stills_, frame, settings);
    return settled;
}

Still SceneRenderer::render(const Scene& scene, const Settings& settings,
                            const StillOptions& options, StillReport* report)
{
    const gl::Device& gl = renderer_.device();
    const glm::ivec2 size(scene.resolution);
    check_size(size, gl);
    const double setup_ms = set_scene(scene, settings);
    if (report != nullptr)
        report->setup_ms = setup_ms;

    const Canvas canvas(gl, scene);
    const gl::Texture& color = canvas.color;
    const gl::Texture& depth = canvas.depth;
    Frame frame;
    View* view = &stills_;
    const auto aim = [&](int i) {
        frame = canvas.frame(scene.camera, settings, i, options.seed);
        view = &stills_;
        if (options.moving_frame) {
            // Each frame has jitter of its own, however many are averaged in it.
            const std::uint64_t number =
                *options.moving_frame * static_cast<std::uint64_t>(options.aa) +
                static_cast<std::uint64_t>(i);
            frame.index += number;
            frame.jitter_offset =
                golden_fraction(static_cast<double>(number) + 1024.0 * options.seed);
            view = options.aa == 1 ? &moving_ : &stills_;
        }
    };
    // Frames that are averaged are each a picture of their own. One picture of several frames that
    // have a history is what they have gathered.
    const bool moves = options.moving_frame.has_value();
    const bool gathers = report != nullptr && !moves && options.aa == 1 &&
                         options.timed_frames > 1 && settings.keeps_history();
    const auto aim_to_gather = [&](int i) {
        aim(0);
        frame.index += static_cast<std::uint64_t>(i);
        view = &moving_;
    };

    const int warm_up = gathers ? 3 : 1;
    const int all = (report != nullptr && !moves ? warm_up + options.timed_frames : 0) +
                    (options.picture ? options.aa : 0);
    int done = 0;
    const auto tell = [&] {
        if (options.progress)
            options.progress(done++, all);
    };
    const auto draw = [&] {
        tell();
        renderer_.draw_surfaces(frame, settings, false);
        renderer_.draw_surfaces(frame, settings, true);
        renderer_.composite(*view, frame, settings);
    };

    if (report != nullptr && !moves) {
        std::vector<std::string> order;
        std::map<std::string, std::vector<double>> times;
        std::vector<double> volume;
        aim(0);
        draw();  // compiles, and warms caches
        if (gathers) {
            aim_to_gather(0);
            draw();
            draw();  // the variant that reads history
            moving_.reset_history();
        }
        renderer_.set_timing(renderer_.measuring_timing());
        for (int i = 0; i < options.timed_frames; ++i) {
            if (gathers)
                aim_to_gather(i);
            draw();
            const FrameReport one = timed_report();
            volume.push_back(volume_ms(one.pass_ms));
            for (const auto& [name, ms] : one.pass_ms) {
                if (times.find(name) == times.end())
                    order.push_back(name);
                times[name].push_back(ms);
            }
        }
        renderer_.set_timing(Timing::off);
        for (const std::string& name : order)
            report->passes.push_back(summarize(name, times[name]));
        report->volume = summarize("volume", volume);
        report->timing_method = timing_name(renderer_.measuring_timing());
        report->history = renderer_.take_report().history;
        report->samples = renderer_.count_samples(*view, frame, settings);
    }

    Still still;
    if (!options.picture) {
        if (report != nullptr)
            report->gpu_bytes = renderer_.take_report().gpu_bytes;
        return still;
    }
    still.width = size.x;
    still.height = size.y;
    Mean composite(size.x, size.y, 3), scattering(size.x, size.y, 3),
        transmittance(size.x, size.y, 3), surface(size.x, size.y, 3),
        surface_lit(size.x, size.y, 3), foreground(size.x, size.y, 4);
    for (int i = 0; i < options.aa; ++i) {
        tell();
        if (gathers)
            aim_to_gather(options.timed_frames);
        else
            aim(i);
        if (report != nullptr && moves && i == 0) {
            renderer_.set_timing(renderer_.measuring_timing());
        }
        renderer_.draw_surfaces(frame, settings, false);
        surface.add(color.read(4));
        renderer_.draw_surfaces(frame, settings, true);
        const std::vector<float> lit = color.read(4);
        surface_lit.add(lit);
        renderer_.composite(*view, frame, settings);
        if (report != nullptr && moves && i == 0) {
            const FrameReport one = timed_report();
            renderer_.set_timing(Timing::off);
            for (const auto& [name, ms] : one.pass_ms)
                report->passes.push_back({name, ms, ms, ms});
            report->volume = summarize("volume", {volume_ms(one.pass_ms)});
            report->timing_method = timing_name(renderer_.measuring_timing());
            report->history = one.history;
        }
        composite.add(color.read(4));
        const LayerImages layers = renderer_.read_layers(*view, frame, settings);
        scattering.add(layers.scattering);
        transmittance.add(layers.transmittance);

        const std::vector<float> window_depth = gl::read_texture(gl, depth.view(), 1, true);
        if (i == 0)
            still.depth = view_depth(frame, window_depth);
        if (options.foreground)
            foreground.add(without_sky(layers, lit, window_depth));
    }
    tell();
    if (report != nullptr)
        report->gpu_bytes = renderer_.take_report().gpu_bytes;
    still.composite = composite.get();
    still.scattering = scattering.get();
    still.transmittance = transmittance.get();
    still.surface = surface.get();
    still.surface_lit = surface_lit.get();
    if (options.foreground)
        still.foreground = foreground.get();
    return still;
}

Glance SceneRenderer::glance(const Scene& scene, const Settings& settings, int frames,
                             double seconds)
{
    const gl::Device& gl = renderer_.device();
    const glm::ivec2 size(scene.resolution);
    check_size(size, gl);
    Glance glance;
    glance.setup_ms = set_scene(scene, settings);
    const Canvas canvas(gl, scene);
    const Frame frame = canvas.frame(scene.camera, settings, 0, 0);
    const auto draw = [&] {
        renderer_.draw_surfaces(frame, settings, false);
        renderer_.draw_surfaces(frame, settings, true);
        renderer_.composite(stills_, frame, settings);
    };
    const auto begin = std::chrono::steady_clock::now();
    draw();  // compiles, and warms caches
    gl->Finish();
    renderer_.set_timing(renderer_.measuring_timing());
    std::vector<double> volume;
    const auto in_time = [&] {
        return std::chrono::steady_clock::now() - begin < std::chrono::duration<double>(seconds);
    };
    while (static_cast<int>(volume.size()) < frames && (volume.empty() || in_time())) {
        draw();
        volume.push_back(volume_ms(timed_report().pass_ms));
    }
    renderer_.set_timing(Timing::off);
    glance.volume = summarize("volume", volume);
    Mean composite(size.x, size.y, 3);
    composite.add(canvas.color.read(4));
    glance.composite = composite.get();
    return glance;
}

InspectionStill SceneRenderer::inspect(const Scene& scene, const Settings& settings,
                                       const Inspection& inspection, std::uint32_t seed)
{
    const gl::Device& gl = renderer_.device();
    const glm::ivec2 size(scene.resolution);
    check_size(size, gl);
    set_scene(scene, settings);
    const Canvas canvas(gl, scene);
    const Frame frame = canvas.frame(scene.camera, settings, 0, seed);
    renderer_.draw_surfaces(frame, settings, true);
    InspectionStill still;
    still.width = size.x;
    still.height = size.y;
    still.legend = renderer_.inspect(stills_, frame, settings, inspection);
    Mean pixels(size.x, size.y, 3);
    pixels.add(canvas.color.read(4));
    still.pixels = pixels.get();
    return still;
}

}  // namespace fumarole
