// Group 7: pictures that follow each other.

#include <cmath>
#include <fmt/format.h>
#include <numbers>

#include "study/stability_bench.h"

namespace fumarole::study {

namespace {

constexpr std::uint32_t kFrames = 16;

/// The pixels' standard deviation over frames that should be alike, over the picture's mean; the
/// picture of the last frame beside the mean of all.
template <class Draw> StabilityFigure spread_in_time(const Draw& draw)
{
    std::vector<double> sum, squares;
    Picture last;
    for (std::uint32_t frame = 0; frame < kFrames; ++frame) {
        last = draw(frame);
        sum.resize(last.rgb.size());
        squares.resize(last.rgb.size());
        for (std::size_t i = 0; i < sum.size(); ++i) {
            sum[i] += double(last.rgb[i]);
            squares[i] += std::pow(double(last.rgb[i]), 2);
        }
    }
    Picture mean{last.width, last.height, {}};
    double variance = 0;
    for (std::size_t i = 0; i < sum.size(); ++i) {
        const double m = sum[i] / kFrames;
        mean.rgb.push_back(static_cast<float>(m));
        variance += std::max(0.0, squares[i] / kFrames - m * m) * kFrames / (kFrames - 1.0);
    }
    StabilityFigure figure = rms_over_mean(last, mean);
    figure.value = std::sqrt(variance / static_cast<double>(sum.size())) / mean.mean();
    return figure;
}

/// Of frames on their own: what jitter alone does.
StabilityFigure flicker(const StabilityBench& bench, const Scene& scene)
{
    return spread_in_time([&](std::uint32_t frame) {
        return layer(bench.render(scene, bench.settings, frame), &Still::composite);
    });
}

Scene lit_fog()
{
    Scene scene = bare_scene(48);
    BoxMedium box = slab(4, 6);
    box.sigma_s = {0.2f, 0.5f, 1.0f};
    box.sigma_a = glm::vec3(0.1f);
    box.g = 0.4f;
    scene.media = {box};
    scene.lights = {SunLight{{0.3, 0.8, 0.5}, {5, 4, 3}}};
    return scene;
}

Scene lit_smoke()
{
    Scene scene = bare_scene(48);
    scene.media = {lump(4, 0.5)};
    scene.lights = {SunLight{{0.7, 0.3, 0.6}, glm::vec3(4)}};
    return scene;
}

Scene beam_in_fog()
{
    Scene scene = bare_scene(48);
    BoxMedium fog;
    fog.min = {-8, -12, -8};
    fog.max = {8, 2, 8};
    fog.sigma_s = glm::vec3(0.1f);
    scene.media = {fog};
    scene.lights = {SpotLight{{0, -5, 3}, {0, 0, -1}, 40, 0.3, glm::vec3(10)}};
    return scene;
}

Scene noisy_smoke()
{
    Scene scene = bare_scene(32);
    BoxMedium box;
    box.min = {-1.2, -6, -1};
    box.max = {1, -4, 1.1};
    box.sigma_s = glm::vec3(2);
    box.sigma_a = glm::vec3(1);
    box.emission = glm::vec3(0.5f);
    box.profile = NoiseProfile{
        .feature_size = 0.7, .octaves = 3, .threshold = 0.3, .seed = 11, .drift = {0.9, -0.6, 0.3}};
    scene.media = {box};
    return scene;
}

struct Subject {
    std::string_view name, words;
    Scene (*scene)();
};

constexpr std::array kSubjects{Subject{"fog", "uniform fog in a sun", lit_fog},
                               Subject{"smoke", "smoke in a sun that shades itself", lit_smoke},
                               Subject{"beam", "a spot's beam in fog", beam_in_fog},
                               Subject{"noise", "glowing noise", noisy_smoke}};

/// A move of the camera: `t` in 0..1.
struct Move {
    std::string_view name, words;
    void (*place)(Camera& camera, double t);
};

constexpr std::array kMoves{
    Move{"pan", "a pan over 40 degrees",
         [](Camera& camera, double t) {
             const double angle = glm::radians(40 * (t - 0.5));
             camera.look_at = glm::dvec3(std::sin(angle), -std::cos(angle), 0);
         }},
    Move{"dolly", "a dolly of 3 m towards the fog",
         [](Camera& camera, double t) {
             camera.position.y = -3 * t;
             camera.look_at = camera.position + glm::dvec3(0, -1, 0);
         }},
    Move{"orbit", "an orbit over 60 degrees round a point in the fog",
         [](Camera& camera, double t) {
             const double angle = glm::radians(60 * (t - 0.5));
             camera.look_at = {0, -5, 0};
             camera.position =
                 camera.look_at + 5.0 * glm::dvec3(std::sin(angle), std::cos(angle), 0.0);
         }},
};

/// The worst frame of a move, against the truth of that frame.
StabilityFigure moving_error(const StabilityBench& bench, const Move& move)
{
    StabilityFigure worst;
    for (std::uint32_t frame = 0; frame < kFrames; ++frame) {
        Scene scene = lit_fog();
        move.place(scene.camera, frame / (kFrames - 1.0));
        const auto& box = std::get<BoxMedium>(scene.media[0]);
        const auto& sun = std::get<SunLight>(scene.lights[0]);
        const Picture truth =
            evaluate(scene, [&](const PixelRay& ray) { return sun_in_slab(scene, ray, box, sun); });
        const Still still = bench.render(scene, bench.settings, frame);
        worst = worse(worst, rms_over_mean(layer(still, &Still::scattering), truth));
    }
    return worst;
}

/// The same place passed forwards and backwards: largest difference of the picture's mean.
StabilityFigure direction_drift(const StabilityBench& bench, const Move& move)
{
    Scene scene = lit_smoke();
    std::vector<Picture> forward;
    for (std::uint32_t frame = 0; frame < kFrames; ++frame) {
        move.place(scene.camera, frame / (kFrames - 1.0));
        forward.push_back(layer(bench.render(scene, bench.settings, frame), &Still::composite));
    }
    StabilityFigure worst;
    for (std::uint32_t frame = 0; frame < kFrames; ++frame) {
        const std::size_t same = kFrames - 1 - frame;
        move.place(scene.camera, static_cast<double>(same) / (kFrames - 1.0));
        const Still still = bench.render(scene, bench.settings, kFrames + frame);
        worst = worse(worst, mean_ratio(layer(still, &Still::composite), forward[same]));
    }
    return worst;
}

/// Something that changes between two frames: `state` counts frames before (< 0) and from it on.
struct Change {
    std::string_view name, words;
    Scene (*scene)(int state);
    bool view_alone = false;  ///< a host has no scene to set anew
};

constexpr std::array kChanges{
    Change{"cut", "a cut to another camera",
           [](int state) {
               Scene scene = lit_smoke();
               if (state >= 0) {
                   scene.camera.position = {3, -8, 2};
                   scene.camera.look_at = {0, -5, 0};
               }
               return scene;
           },
           true},
    Change{"light-switched", "a light switched on",
           [](int state) {
               Scene scene = lit_smoke();
               if (state >= 0)
                   scene.lights.emplace_back(PointLight{{1.5, -4, 1}, glm::vec3(20)});
               return scene;
           }},
    Change{"moving-light", "a light that moves half a metre a frame, then stands",
           [](int state) {
               Scene scene = lit_smoke();
               scene.lights = {PointLight{{2, -4 + 0.5 * std::min(state, 0), 1}, glm::vec3(20)}};
               return scene;
           }},
    Change{"coloured-light", "a pane that has coloured the light on its way passes and is gone",
           [](int state) {
               Scene scene = lit_smoke();
               QuadTransparent pane;  // above all that is seen
               pane.corner = {1.5 + 0.2 * state, -7.5, 3};
               pane.edges = {glm::dvec3(6, 0, 0), glm::dvec3(0, 8, 0)};
               pane.look.blend.kind = Blend::Kind::multiply;
               pane.look.filter = {0.85f, 0.45f, 0.25f};
               pane.look.casts = true;
               if (state < 0)
                   scene.transparents = {pane};
               return scene;
           }},
    Change{"animated-media", "drifting noise that comes to stand",
           [](int state) {
               Scene scene = noisy_smoke();
               scene.time = std::min(state, 0) / 4.0;
               return scene;
           }},
};

/// Frames after a change until one is within 1 % of what it is where nothing ever changed.
StabilityFigure ghosting(const StabilityBench& bench, const Change& change)
{
    constexpr std::uint32_t kPast = 8, kAfter = 8;
    const Scene after = change.scene(0);
    // What would be there with no change: as long in that state before, then the same frames.
    std::vector<Picture> settled;
    for (std::uint32_t i = 0; i < kPast + kAfter; ++i)
        settled.push_back(layer(bench.render(after, bench.settings, i), &Still::composite));
    for (std::uint32_t i = 0; i < kPast; ++i)
        (void)bench.render(change.scene(static_cast<int>(i) - static_cast<int>(kPast)),
                           bench.settings, i);
    StabilityFigure figure;
    for (std::uint32_t i = 0; i < kAfter; ++i) {
        const Still still = bench.render(after, bench.settings, kPast + i);
        StabilityFigure now = rms_over_mean(layer(still, &Still::composite), settled[kPast + i]);
        if (now.value <= kJustNoticed)
            break;
        figure.value = i + 1;
        figure.pictures = std::move(now.pictures);
    }
    return figure;
}

// -- a view that keeps its history ---------------------------------------------------------------

/// What keeps one: froxels, and the march where it is asked to.
struct Keeper {
    std::string_view prefix;  ///< prefix of its cases
    bool (*runs)(const StabilitySubject& subject);
    Settings (*settings)(const StabilityBench& bench);
};

constexpr std::array kKeepers{
    Keeper{"", has_froxels, [](const StabilityBench& bench) { return bench.settings; }},
    Keeper{"temporal-", marches,
           [](const StabilityBench& bench) { return bench.with("temporal", "on"); }}};

constexpr int kConverged = 128;  ///< frames of a still view, whose mean is taken for the truth

/// What a scene's view comes to, with nothing before it.
Picture converged(const StabilityBench& bench, const Settings& settings, const Scene& scene)
{
    return bench.gathered(scene, settings, kConverged);
}

/// Frames after a change until one is within 1 % of what they converge to, or within twice the
/// noise of a frame with as long a history and no change in it, where that is more.
StabilityFigure settling(const StabilityBench& bench, const Settings& settings,
                         const Change& change)
{
    constexpr int kPast = 24, kAfter = 96;
    const Scene after = change.scene(0);
    const Picture truth = converged(bench, settings, after);
    StabilityView unchanged(bench, settings);
    unchanged.set_scene(after);
    for (int i = 1; i < kPast; ++i)
        (void)unchanged.draw(after);
    const double noise = rms_over_mean(unchanged.draw(after), truth).value;
    const double near = std::max(kJustNoticed, 2 * noise);
    StabilityView view(bench, settings);
    for (int i = -kPast; i < 0; ++i) {
        const Scene before = change.scene(i);
        if (i == -kPast || !change.view_alone)
            view.set_scene(before);
        (void)view.draw(before);
    }
    if (!change.view_alone)
        view.set_scene(after);
    StabilityFigure figure;
    for (int i = 0; i < kAfter; ++i) {
        StabilityFigure now = rms_over_mean(view.draw(after), truth);
        if (now.value <= near)
            break;
        figure.value = i + 1;
        figure.pictures = std::move(now.pictures);
    }
    return figure;
}

/// As flicker, once a still view has gathered 32 frames.
StabilityFigure gathered_flicker(const StabilityBench& bench, const Settings& settings,
                                 const Scene& scene)
{
    StabilityView view(bench, settings);
    view.set_scene(scene);
    for (int i = 0; i < 32; ++i)
        (void)view.draw(scene);
    return spread_in_time([&](std::uint32_t) { return view.draw(scene); });
}

/// A steady motion of the view, `frame` frames of it.
struct Way {
    std::string_view name, words;
    void (*place)(Camera& camera, int frame);
};

void travel(Camera& camera, glm::dvec3 by)
{
    camera.position = by;
    camera.look_at = by + glm::dvec3(0, -1, 0);
}

constexpr std::array kWays{
    Way{"ahead", "forwards, 4 cm a frame",
        [](Camera& camera, int frame) {
            travel(camera, {0, -0.04 * frame, 0});
        }},
    Way{"back", "backwards, 4 cm a frame",
        [](Camera& camera, int frame) {
            travel(camera, {0, 0.04 * frame - 1, 0});
        }},
    Way{"sideways", "sideways, 4 cm a frame",
        [](Camera& camera, int frame) {
            travel(camera, {0.04 * (frame - 12), 0, 0});
        }},
    Way{"turning", "turning half a degree a frame",
        [](Camera& camera, int frame) {
            const double angle = glm::radians(0.5 * (frame - 12));
            camera.look_at = {std::sin(angle), -std::cos(angle), 0};
        }},
};

/// The last of 25 frames on the way beside what that view converges to at rest.
struct Moved {
    Picture actual, truth;
};

Moved moved(const StabilityBench& bench, const Settings& settings, Scene scene, const Way& way)
{
    constexpr int kLast = 24;
    scene.resolution *= 2u;  // or the smoke is three columns wide
    Picture last;
    {
        StabilityView view(bench, settings);
        view.set_scene(scene);
        for (int frame = 0; frame <= kLast; ++frame) {
            way.place(scene.camera, frame);
            last = view.draw(scene);
        }
    }
    return {last, converged(bench, settings, scene)};
}

void add_history_cases(std::vector<StabilityCase>& table, const Keeper& keeper)
{
    const std::string notice(kNoticeReason);
    const auto add = [&](const std::string& name, std::string shows, double bound, std::string unit,
                         std::string reason, bool quick, decltype(StabilityCase::measure) measure) {
        table.push_back({.group = 7,
                         .name = std::string(keeper.prefix) + name,
                         .shows = std::move(shows),
                         .bound = bound,
                         .unit = std::move(unit),
                         .reason = std::move(reason),
                         .quick = quick,
                         .runs = keeper.runs,
                         .measure = std::move(measure)});
    };
    for (const Change& change : kChanges)
        add(fmt::format("settle-{}", change.name),
            fmt::format(
                "frames after {} until within 1 % of the converged picture, or within twice the "
                "noise of a frame with a history, where that is more",
                change.words),
            6, "frames",
            "0.1 s at 60 frames a second: the time over which an eye sums up light (Bloch's law)",
            change.name == "light-switched", [change, keeper](const StabilityBench& bench) {
                return settling(bench, keeper.settings(bench), change);
            });
    for (const Subject& subject : kSubjects)
        add(fmt::format("flicker-{}-gathered", subject.name),
            fmt::format("as flicker-{}, once a still view has gathered 32 frames", subject.name),
            kJustNoticed, "of the mean", notice + "; a change in time is seen at least as well",
            subject.name == "smoke", [subject, keeper](const StabilityBench& bench) {
                return gathered_flicker(bench, keeper.settings(bench), subject.scene());
            });
    for (const Subject& subject : {kSubjects[0], kSubjects[1]})
        for (const Way& way : kWays) {
            add(fmt::format("drift-{}-{}", subject.name, way.name),
                fmt::format("brightness of {} on the 25th frame of a view that goes {}, against "
                            "that view at rest",
                            subject.words, way.words),
                1e-3, "of the mean",
                "a tenth of what is just noticed, since the eye follows a whole picture's "
                "brightness over time",
                way.name == "ahead", [subject, way, keeper](const StabilityBench& bench) {
                    const Moved both = moved(bench, keeper.settings(bench), subject.scene(), way);
                    return mean_ratio(both.actual, both.truth);
                });
            add(fmt::format("smear-{}-{}", subject.name, way.name),
                "rms difference of the same two pictures", kJustNoticed, "of the mean", notice,
                false, [subject, way, keeper](const StabilityBench& bench) {
                    const Moved both = moved(bench, keeper.settings(bench), subject.scene(), way);
                    return rms_over_mean(both.actual, both.truth);
                });
        }
}

// -- fewer steps, with a history -----------------------------------------------------------------

/// What a quarter of the steps comes to in a view that moves, with a history, against what `steps`
/// do without: the rms error of one over that of the other, both against many steps, over the last
/// frames of 24. A history takes noise away, and not what few steps do whatever their jitter.
StabilityFigure gain(const StabilityBench& bench, Scene scene, const Way& way, int steps)
{
    constexpr int kMoving = 24, kLast = 3, kTruth = 32;
    scene.resolution *= 2u;
    Settings few = bench.with("temporal", "on"), many = bench.settings, all = few;
    few.steps = bench.settings.steps / 4;
    many.steps = steps;
    all.steps = 4 * bench.settings.steps;
    const auto frames = [&](const Settings& settings) {
        std::vector<Picture> last;
        StabilityView view(bench, settings);
        view.set_scene(scene);
        for (int frame = 0; frame < kMoving; ++frame) {
            way.place(scene.camera, frame);
            last.push_back(view.draw(scene));
        }
        last.erase(last.begin(), last.end() - kLast);
        return last;
    };
    const std::vector<Picture> with = frames(few), without = frames(many);
    StabilityFigure worst;
    double square_with = 0, square_without = 0;
    for (int i = 0; i < kLast; ++i) {
        way.place(scene.camera, kMoving - kLast + i);
        const Picture truth = bench.gathered(scene, all, kTruth);
        const auto at = static_cast<std::size_t>(i);
        StabilityFigure now = rms_over_mean(with[at], truth);
        square_with += now.value * now.value;
        square_without += std::pow(rms_over_mean(without[at], truth).value, 2);
        worst = worse(worst, std::move(now));
    }
    worst.value = std::sqrt(square_with / square_without);
    return worst;
}

void add_gain_cases(std::vector<StabilityCase>& table)
{
    for (const Subject& subject : {kSubjects[1], kSubjects[2]})
        for (const Way& way : {kWays[2], kWays[3]})
            for (const bool same : {false, true})
                table.push_back(
                    {.group = 7,
                     .name = fmt::format("temporal-{}-{}-{}", same ? "same-steps" : "fewer-steps",
                                         subject.name, way.name),
                     .shows =
                         fmt::format("rms error of {} in a view that goes {}: a quarter of the "
                                     "steps with a history, over {} without",
                                     subject.words, way.words, same ? "as few" : "all of them"),
                     .bound = 1,
                     .unit = "of the error",
                     .reason = same ? "or a history does harm"
                                    : "what it is for: the error of four times the steps",
                     .quick = subject.name == "smoke" && way.name == "sideways",
                     .runs = marches,
                     .measure = [subject, way, same](const StabilityBench& bench) {
                         return gain(bench, subject.scene(), way,
                                     bench.settings.steps / (same ? 4 : 1));
                     }});
}

}  // namespace

void add_motion_cases(std::vector<StabilityCase>& table)
{
    const std::string notice(kNoticeReason);
    for (const Subject& still : kSubjects)
        table.push_back({.group = 7,
                         .name = fmt::format("flicker-{}", still.name),
                         .shows = fmt::format("standard deviation of a pixel over 16 frames of {}",
                                              still.words),
                         .bound = kJustNoticed,
                         .unit = "of the mean",
                         .reason = notice + "; a change in time is seen at least as well",
                         .measure = [scene = still.scene](const StabilityBench& bench) {
                             return flicker(bench, scene());
                         }});
    for (const Move& move : kMoves) {
        table.push_back(
            {.group = 7,
             .name = fmt::format("{}-error", move.name),
             .shows = fmt::format("rms error of the worst frame of {}", move.words),
             .bound = kJustNoticed,
             .unit = "of the mean",
             .reason = notice,
             .measure = [move](const StabilityBench& bench) { return moving_error(bench, move); }});
        table.push_back(
            {.group = 7,
             .name = fmt::format("{}-drift", move.name),
             .shows = fmt::format("brightness of a place passed forwards and backwards in {}",
                                  move.words),
             .bound = 1e-3,
             .unit = "of the mean",
             .reason = "a tenth of what is just noticed, since the eye follows a whole picture's "
                       "brightness over time",
             .quick = move.name == "pan",
             .measure = [move](const StabilityBench& bench) {
                 return direction_drift(bench, move);
             }});
    }
    for (const Change& change : kChanges)
        table.push_back(
            {.group = 7,
             .name = fmt::format("ghost-{}", change.name),
             .shows = fmt::format("frames until within 1 % after {}", change.words),
             .bound = 0,
             .unit = "frames",
             .reason = "without history the first frame is right at once",
             .quick = change.name == "cut",
             .measure = [change](const StabilityBench& bench) { return ghosting(bench, change); }});
    for (const Keeper& keeper : kKeepers)
        add_history_cases(table, keeper);
    add_gain_cases(table);
}

}  // namespace fumarole::study
