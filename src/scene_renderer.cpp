#include <fumarole/scene_renderer.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>
#include <map>

#include "gl/texture.h"
#include "halton.h"
#include "picture_parts.h"
#include <fumarole/errors.h>

namespace fumarole {

namespace {

constexpr std::uint64_t kTimedFrames = 8;  ///< of so many frames of a moving picture one is timed

/// A whole picture that is drawn at once.
PicturePart whole_part(glm::ivec2 size)
{
    return {{0, 0}, size, {0, 0}, size};
}

/// The mean of several pictures of a part, or of what is kept of it, rows turned to come from the
/// top.
class Mean {
public:
    /// @param used or else it stays empty
    Mean(const PicturePart& part, int channels, bool used = true)
        : stride_{static_cast<std::size_t>(part.size.x)}, pixels_{stride_ *
                                                                  static_cast<std::size_t>(
                                                                      part.size.y)},
          left_{static_cast<std::size_t>(part.keep_origin.x)}, bottom_{static_cast<std::size_t>(
                                                                   part.keep_origin.y)},
          width_{used ? static_cast<std::size_t>(part.keep_size.x) : 0},
          height_{used ? static_cast<std::size_t>(part.keep_size.y) : 0},
          channels_{static_cast<std::size_t>(channels)}, sum_(width_ * height_ * channels_)
    {
    }

    /// `from` may have more channels; the first ones are taken.
    void add(const std::vector<float>& from)
    {
        const std::size_t stride = from.size() / pixels_;
        for (std::size_t y = 0; y < height_; ++y)
            for (std::size_t x = 0; x < width_; ++x)
                for (std::size_t c = 0; c < channels_; ++c)
                    sum_[((height_ - 1 - y) * width_ + x) * channels_ + c] +=
                        from[((y + bottom_) * stride_ + x + left_) * stride + c];
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

    /// Of what was added here and not there.
    [[nodiscard]] std::vector<float> get_without(const Mean& part) const
    {
        std::vector<float> mean;
        mean.reserve(sum_.size());
        for (std::size_t i = 0; i < sum_.size(); ++i)
            mean.push_back(static_cast<float>((sum_[i] - part.sum_[i]) / (count_ - part.count_)));
        return mean;
    }

private:
    std::size_t stride_, pixels_, left_, bottom_, width_, height_, channels_;
    std::vector<double> sum_;
    int count_ = 0;
};

/// Halton's bases 2 and 3, over -0.5..0.5; point 0 is the middle.
glm::dvec2 layer_offset(std::uint64_t i)
{
    return glm::fract(glm::dvec2(radical_inverse(i, 2), radical_inverse(i, 3)) + 0.5) - 0.5;
}

/// view_z [m] of our own reversed depth, rows from the top.
std::vector<float> view_depth(const Frame& frame, const PicturePart& part,
                              const std::vector<float>& window_depth)
{
    const glm::dmat4& p = frame.clip_from_view;
    std::vector<float> view_z;
    view_z.reserve(window_depth.size());
    for (const double n : window_depth)
        view_z.push_back(
            n == 0 ? Still::kSkyDepth
                   : static_cast<float>((p[3][3] * n - p[3][2]) / (p[2][3] * n - p[2][2])));
    Mean one(part, 1);
    one.add(view_z);
    return one.get();
}

/// RGBA of Still::foreground for one frame.
std::vector<float> without_sky(const LayerImages& layers, const TransparentImages& transparents,
                               const std::vector<float>& lit,
                               const std::vector<float>& window_depth)
{
    std::vector<float> rgba;
    for (std::size_t i = 0; i < window_depth.size(); ++i) {
        const bool sky = window_depth[i] == 0;
        float alpha = 0;
        for (std::size_t c = 0; c < 3; ++c) {
            const float through = layers.transmittance[i * 3 + c];
            const float behind =
                layers.scattering[i * 3 + c] + (sky ? 0.0f : through * lit[i * 4 + c]);
            const bool none = transparents.kept.empty();
            const float kept = none ? 1.0f : transparents.kept[i * 3 + c];
            rgba.push_back(none ? behind : kept * behind + transparents.added[i * 3 + c]);
            alpha += (sky ? 1.0f - (none ? through : kept * through) : 1.0f) / 3.0f;
        }
        rgba.push_back(alpha);
    }
    return rgba;
}

bool averages(const StillOptions& options)
{
    return options.aa > 1 || options.enough;
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
    Canvas(const gl::Device& gl, glm::ivec2 size)
        : color{gl::Texture::make_2d(gl, "picture", size, GL_RGBA32F, gl::Filter::nearest)},
          depth{gl::Texture::make_2d(gl, "picture depth", size, GL_DEPTH_COMPONENT32F,
                                     gl::Filter::nearest)}
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

PictureRegion whole_region(glm::uvec2 size)
{
    return {0, 0, static_cast<int>(size.x), static_cast<int>(size.y)};
}

void check_region(const PictureRegion& region, glm::uvec2 size)
{
    const auto within = [](int from, int length, unsigned all) {
        return from >= 0 && length > 0 && length <= static_cast<int>(all) &&
               from <= static_cast<int>(all) - length;
    };
    if (!within(region.x, region.width, size.x) || !within(region.y, region.height, size.y))
        throw Error(fmt::format("the region {} {} {} {} (x y width height) lies not within the "
                                "picture of {} x {}; give one that does",
                                region.x, region.y, region.width, region.height, size.x, size.y));
}

/// What a part knows nothing of: the frames before it, and what else is in view.
void check_parts(const Settings& settings, bool builds_on_frames)
{
    if (builds_on_frames)
        throw Error("a part of a picture, or a picture in tiles, has no history, which needs all "
                    "of the view; set history 0, or average frames instead (StillOptions::aa)");
    if (settings.mode == Settings::Mode::froxel &&
        settings.froxel_shadows == Settings::FroxelShadows::grid)
        throw Error("froxel_shadows grid needs all of the view, and a part of a picture, or a "
                    "picture in tiles, has not; set froxel_shadows media");
}

/// Frames that a still of this size takes, by a smaller copy of it.
int frames_of_copy(SceneRenderer& renderer, const Scene& scene, const Settings& settings,
                   StillOptions options)
{
    constexpr double kSide = 1024;
    Scene copy = scene;
    const glm::dvec2 size(scene.resolution);
    copy.resolution =
        glm::max(glm::uvec2(glm::round(size * (kSide / std::max(size.x, size.y)))), 1u);
    options.region.reset();
    options.layers = false;
    options.foreground = false;
    options.progress = {};
    options.most_side = 0;
    return renderer.render(copy, settings, options).frames;
}

/// Puts a part's pictures where they belong.
class Pasting {
public:
    Pasting(Still& still, const PicturePart& part, int bottom, int left)
        : still_{still}, part_{part}, bottom_{bottom}, left_{left}
    {
    }

    void paste(std::vector<float> Still::*picture, const Still& from, std::size_t channels)
    {
        const std::vector<float>& rows = from.*picture;
        if (rows.empty())
            return;
        std::vector<float>& to = still_.*picture;
        const auto width = static_cast<std::size_t>(still_.width);
        to.resize(width * static_cast<std::size_t>(still_.height) * channels);
        const std::size_t row = static_cast<std::size_t>(part_.keep_size.x) * channels;
        const int top =
            still_.height - (part_.origin.y + part_.keep_origin.y - bottom_) - part_.keep_size.y;
        const int begin = part_.origin.x + part_.keep_origin.x - left_;
        for (int y = 0; y < part_.keep_size.y; ++y)
            std::copy_n(rows.begin() + static_cast<std::ptrdiff_t>(row) * y, row,
                        to.begin() +
                            static_cast<std::ptrdiff_t>((static_cast<std::size_t>(top + y) * width +
                                                         static_cast<std::size_t>(begin)) *
                                                        channels));
    }

private:
    Still& still_;
    const PicturePart& part_;
    int bottom_, left_;  ///< lower left corner of the still in the whole picture
};

/// The cost of one part more.
void add_cost(StillReport& sum, const StillReport& part)
{
    const auto add = [](PassTime& to, const PassTime& one) {
        to.min_ms += one.min_ms;
        to.median_ms += one.median_ms;
        to.max_ms += one.max_ms;
    };
    for (const PassTime& pass : part.passes) {
        const auto same = std::find_if(sum.passes.begin(), sum.passes.end(),
                                       [&](const PassTime& p) { return p.name == pass.name; });
        if (same == sum.passes.end())
            sum.passes.push_back(pass);
        else
            add(*same, pass);
    }
    sum.volume.name = part.volume.name;
    add(sum.volume, part.volume);
    sum.timing_method = part.timing_method;
    const auto evenness = [&](double StillReport::*even) {
        const auto taken = [&](const StillReport& of) {
            return of.*even > 0 ? of.samples / (of.*even) : 0;
        };
        const double all = taken(sum) + taken(part);
        return all > 0 ? (sum.samples + part.samples) / all : 0;
    };
    sum.even_4 = evenness(&StillReport::even_4);
    sum.even_8 = evenness(&StillReport::even_8);
    sum.samples += part.samples;
    sum.gpu_bytes = std::max(sum.gpu_bytes, part.gpu_bytes);
}

/// While it lives the renderer measures by waiting, so that explain() says what its volumes and
/// probes took.
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

int averaged_resolution(int settled)
{
    return settled > 1 ? settled / 2 : settled;
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

double SceneRenderer::set_scene(const Scene& scene, const SceneSettings& settings, bool moves)
{
    // While a sequence plays its probes stay as they were captured first.
    using Update = SceneSettings::ProbeUpdate;
    const auto update_probes = [&] {
        if (settings.probe_update != Update::never)
            renderer_.update_probes(!moves || settings.probe_update == Update::always);
    };
    if (held_ && held_->second == settings && same_content(held_->first, scene)) {
        update_probes();
        return 0;
    }
    const auto begin = std::chrono::steady_clock::now();
    held_.reset();
    {
        const Measured measured(renderer_);
        renderer_.set_scene(scene, settings);
        update_probes();
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

Settings SceneRenderer::settled(const Scene& scene, const Settings& settings,
                                const StillOptions& options)
{
    Settings out = settled(scene, settings);
    if (averages(options) && settings.resolution == kAutomatic)
        out.resolution = averaged_resolution(out.resolution);
    return out;
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

bool SceneRenderer::has_lost_fragments()
{
    renderer_.wait_until_ready();
    return renderer_.fragment_count().lost > 0;
}

/// A part of a picture that is to be drawn.
struct SceneRenderer::Drawing {
    const Scene& scene;
    const Settings& settings;
    PicturePart part;
};

Still SceneRenderer::render(const Scene& scene, const Settings& asked,
                            const StillOptions& asked_options, StillReport* report)
{
    constexpr int kSide = 4096;  // some 2 GB with all that is read back
    const gl::Device& gl = renderer_.device();
    const glm::ivec2 size(scene.resolution);
    StillOptions options = asked_options;
    const PictureRegion region = options.region.value_or(whole_region(scene.resolution));
    check_region(region, scene.resolution);
    const double setup_ms = set_scene(scene, asked, asked_options.moving_frame.has_value());
    if (report != nullptr)
        report->setup_ms = setup_ms;
    const int limit = std::min(kSide, gl.capabilities().max_texture_2d);
    const int side = options.most_side > 0 ? std::min(options.most_side, limit) : limit;
    if (region == whole_region(scene.resolution) && std::max(size.x, size.y) <= side)
        return draw_part(
            {scene, averages(options) ? settled(scene, asked, options) : asked, whole_part(size)},
            options, report);

    check_parts(asked, asked.keeps_history() && options.aa == 1 &&
                           (options.moving_frame || options.timed_frames > 1));
    const Settings settings = settled(scene, asked, options);
    const std::vector<PicturePart> parts = picture_parts(size, region, side, settings);
    if (options.enough && parts.size() > 1) {
        options.aa = frames_of_copy(*this, scene, asked, options);
        options.enough = {};
    }
    Still still;
    still.width = region.width;
    still.height = region.height;
    for (std::size_t i = 0; i < parts.size(); ++i) {
        if (asked_options.progress)
            options.progress = [&](int done, int all) {
                asked_options.progress(static_cast<int>(i) * all + done,
                                       static_cast<int>(parts.size()) * all);
            };
        StillReport cost;
        const Still part =
            draw_part({scene, settings, parts[i]}, options, report != nullptr ? &cost : nullptr);
        if (report != nullptr)
            add_cost(*report, cost);
        still.frames = part.frames;
        Pasting pasting(still, parts[i], size.y - region.y - region.height, region.x);
        for (const auto picture :
             {&Still::composite, &Still::scattering, &Still::transmittance, &Still::surface,
              &Still::surface_lit, &Still::transparents, &Still::transparents_kept})
            pasting.paste(picture, part, 3);
        pasting.paste(&Still::depth, part, 1);
        pasting.paste(&Still::foreground, part, 4);
    }
    return still;
}

Still SceneRenderer::draw_part(const Drawing& drawing, const StillOptions& options,
                               StillReport* report)
{
    const Scene& scene = drawing.scene;
    const Settings& settings = drawing.settings;
    const PicturePart& part = drawing.part;
    const gl::Device& gl = renderer_.device();
    const Canvas canvas(gl, part.size);
    const gl::Texture& color = canvas.color;
    const gl::Texture& depth = canvas.depth;
    Frame frame;
    View* view = &stills_;
    const auto aim = [&](int i) {
        frame = canvas.frame(scene.camera, settings, i, options.seed);
        const glm::ivec2 whole(scene.resolution);
        frame.clip_from_view = clip_of_part(
            clip_from_view(scene.camera, scene.resolution, subpixel_offset(i)), whole, part);
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
            // Frames of a picture that several processes share must not depend on who drew which.
            if (!settings.keeps_history())
                view->reset_history();
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
        if (gathers)
            aim_to_gather(0);  // from the first on: another view would have volumes of its own
        else
            aim(0);
        draw();  // compiles, and warms caches
        if (gathers) {
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
        FrameReport last = renderer_.take_report();
        report->history = std::move(last.history);
        report->passes_as = std::move(last.passes);
        const SampleCounts counts = renderer_.sample_counts(*view, frame, settings);
        report->samples = counts.all;
        report->even_4 = counts.even_4;
        report->even_8 = counts.even_8;
    }

    Still still;
    if (!options.picture) {
        if (report != nullptr)
            report->gpu_bytes = renderer_.take_report().gpu_bytes;
        return still;
    }
    still.width = part.keep_size.x;
    still.height = part.keep_size.y;
    const bool transparent = options.layers && !scene.transparents.empty();
    const bool layered = options.layers, halved = static_cast<bool>(options.enough);
    Mean composite(part, 3), scattering(part, 3, layered), transmittance(part, 3, layered),
        surface(part, 3, layered), surface_lit(part, 3, layered),
        transparents(part, 3, transparent), kept(part, 3, transparent),
        foreground(part, 4, options.foreground), first(part, 3, halved);
    constexpr int kFewest = 8;  // so that edges of surfaces are smooth, which no one measures
    for (int i = 0; i < options.aa; ++i) {
        tell();
        if (gathers)
            aim_to_gather(options.timed_frames);
        else
            aim(i);
        // Beside what a frame draws it takes the surfaces without the media, and a wait.
        const bool timed =
            report != nullptr && moves && i == 0 && *options.moving_frame % kTimedFrames == 0;
        if (timed)
            renderer_.set_timing(renderer_.measuring_timing());
        if (options.layers || timed)
            renderer_.draw_surfaces(frame, settings, false);
        if (options.layers)
            surface.add(color.read(4));
        renderer_.draw_surfaces(frame, settings, true);
        std::vector<float> lit;
        if (options.layers || options.foreground)
            lit = color.read(4);
        if (options.layers)
            surface_lit.add(lit);
        renderer_.composite(*view, frame, settings);
        if (!scene.transparents.empty() && view == &stills_ && has_lost_fragments()) {
            // There is room for them now; a still has no frame that comes after.
            renderer_.draw_surfaces(frame, settings, true);
            renderer_.composite(*view, frame, settings);
        }
        if (report != nullptr && moves && i == 0) {
            const FrameReport one = timed ? timed_report() : renderer_.take_report();
            report->history = one.history;
            report->passes_as = one.passes;
            if (timed) {
                renderer_.set_timing(Timing::off);
                for (const auto& [name, ms] : one.pass_ms)
                    report->passes.push_back({name, ms, ms, ms});
                report->volume = summarize("volume", {volume_ms(one.pass_ms)});
                report->timing_method = timing_name(renderer_.measuring_timing());
            }
        }
        const std::vector<float> pixels = color.read(4);
        composite.add(pixels);
        still.frames = i + 1;
        if (options.layers || options.foreground) {
            const LayerImages layers = renderer_.read_layers(*view, frame, settings);
            const TransparentImages added = renderer_.read_transparents(*view, frame, settings);
            if (options.layers) {
                scattering.add(layers.scattering);
                transmittance.add(layers.transmittance);
                if (transparent) {
                    transparents.add(added.added);
                    kept.add(added.kept);
                }
            }
            const std::vector<float> window_depth = gl::read_texture(gl, depth.view(), 1, true);
            if (options.layers && i == 0)
                still.depth = view_depth(frame, part, window_depth);
            if (options.foreground)
                foreground.add(without_sky(layers, added, lit, window_depth));
        }
        if (options.enough && std::has_single_bit(static_cast<unsigned>(still.frames))) {
            if (still.frames >= kFewest && options.enough({still.frames, still.width, first.get(),
                                                           composite.get_without(first)}))
                break;
            first = composite;
        }
    }
    if (options.progress)
        options.progress(all, all);
    if (report != nullptr)
        report->gpu_bytes = renderer_.take_report().gpu_bytes;
    still.composite = composite.get();
    if (options.layers) {
        still.scattering = scattering.get();
        still.transmittance = transmittance.get();
        still.surface = surface.get();
        still.surface_lit = surface_lit.get();
        if (transparent) {
            still.transparents = transparents.get();
            still.transparents_kept = kept.get();
        }
    }
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
    const Canvas canvas(gl, size);
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
    Mean composite(whole_part(size), 3);
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
    const Canvas canvas(gl, size);
    const Frame frame = canvas.frame(scene.camera, settings, 0, seed);
    renderer_.draw_surfaces(frame, settings, true);
    InspectionStill still;
    still.width = size.x;
    still.height = size.y;
    still.legend = renderer_.inspect(stills_, frame, settings, inspection);
    if (inspection.kind == Inspection::Kind::layers && has_lost_fragments()) {
        renderer_.draw_surfaces(frame, settings, true);
        still.legend = renderer_.inspect(stills_, frame, settings, inspection);
    }
    Mean pixels(whole_part(size), 3);
    pixels.add(canvas.color.read(4));
    still.pixels = pixels.get();
    return still;
}

}  // namespace fumarole
