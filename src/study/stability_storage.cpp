// Group 8: what the layer's targets keep of a picture, and froxels of their history.

#include <cmath>
#include <fmt/format.h>

#include "study/stability_bench.h"

namespace fumarole::study {

namespace {

/// A slab that glows, coloured so that the small format is used; T and radiance change smoothly.
Scene gradient_scene(float radiance)
{
    Scene scene = bare_scene(64);
    scene.camera.vfov_deg = 70;
    scene.camera.look_at = {0.5, -1, 0.3};
    BoxMedium box = slab(4, 6);
    box.sigma_a = {0.3f, 0.5f, 0.9f};
    box.emission = box.sigma_a * radiance;
    scene.media = {box};
    return scene;
}

/// A frame at full size, so that nothing is interpolated.
Still full_size(const StabilityBench& bench, const Scene& scene, Settings::Format format)
{
    Settings settings = bench.full_size();
    settings.format = format;
    return bench.render(scene, settings, 0);
}

bool has_long_floats(const StabilitySubject& subject)
{
    return subject.settings.format == Settings::Format::rgba32f;
}

/// 32-bit floats against the closed form.
StabilityFigure gradient(const StabilityBench& bench)
{
    const Scene scene = gradient_scene(1);
    const auto& box = std::get<BoxMedium>(scene.media[0]);
    const Still still = full_size(bench, scene, Settings::Format::rgba32f);
    const Picture t =
        evaluate(scene, [&](const PixelRay& ray) { return box_transmittance(scene, ray, box); });
    const Picture glow = evaluate(
        scene, [&](const PixelRay& ray) { return 1.0 - box_transmittance(scene, ray, box); });
    return worse(worst_ratio(layer(still, &Still::transmittance), t),
                 worst_ratio(layer(still, &Still::scattering), glow));
}

/// Other formats against the same frame in 32-bit floats, so that the march's own error is not
/// taken for the format's.
StabilityFigure banding(const StabilityBench& bench)
{
    const Scene scene = gradient_scene(1);
    const Still still = full_size(bench, scene, bench.settings.format);
    const Still exact = full_size(bench, scene, Settings::Format::rgba32f);
    return worse(
        worst_ratio(layer(still, &Still::transmittance), layer(exact, &Still::transmittance)),
        worst_ratio(layer(still, &Still::scattering), layer(exact, &Still::scattering)));
}

StabilityFigure bright(const StabilityBench& bench)
{
    const Scene scene = gradient_scene(2e5f);
    const auto& box = std::get<BoxMedium>(scene.media[0]);
    const Picture truth = evaluate(scene, [&](const PixelRay& ray) {
        return 2e5 * (1.0 - box_transmittance(scene, ray, box));
    });
    return rms_over_mean(layer(full_size(bench, scene, bench.settings.format), &Still::scattering),
                         truth);
}

/// Radiances past what 16 bits hold, and one past what 32 do: 3e38 W/m^2/sr a metre over 2 m.
StabilityFigure finite(const StabilityBench& bench)
{
    std::vector<Scene> scenes{gradient_scene(1e5f), gradient_scene(1e30f), gradient_scene(0)};
    std::get<BoxMedium>(scenes.back().media[0]).emission = glm::vec3(3e38f);
    StabilityFigure bad;
    for (const Scene& scene : scenes)
        bad = worse(bad, count_bad(bench.render(scene, bench.settings, 0)));
    return bad;
}

/// Where the eye was, scattering towards it was another; what is left of that in the history must
/// fade, 5 % a frame. Steps of 5 % that a format rounds away leave it there. The view trembles by a
/// micrometre, since of one that stands still history is a mean, and fades faster.
StabilityFigure stall(const StabilityBench& bench, std::string_view format)
{
    constexpr int kMoving = 16, kFading = 256;
    Settings settings = bench.with("history-format", format);
    settings.jitter = Settings::Jitter::none;
    settings.history = 0.95f;
    // What is kept is to be the one thing that rounds.
    settings.format = Settings::Format::rgba32f;
    Scene scene = bare_scene(48);
    BoxMedium fog = slab(3, 9);
    fog.sigma_s = glm::vec3(0.1f);
    fog.sigma_a = glm::vec3(0.02f);
    fog.profile = ExpHeightProfile{.scale_height = 2, .z0 = -2};
    fog.g = 0.3f;
    scene.media = {fog};
    scene.lights = {SunLight{{0.5, 0.3, 0.8}, glm::vec3(4)}};
    const auto travel = [&](double x) {
        scene.camera.position = {x, 0, 0.2 * x};
        scene.camera.look_at = scene.camera.position + glm::dvec3(0, -1, 0);
    };
    const Picture expected = bench.gathered(scene, settings, 1);
    StabilityView view(bench, settings);
    view.set_scene(scene);
    for (int frame = kMoving; frame > 0; --frame) {
        travel(0.2 * frame);
        (void)view.draw(scene);
    }
    Picture actual;
    for (int frame = 0; frame < kFading; ++frame) {
        travel(frame % 2 == 0 ? 0 : 1e-6);
        actual = view.draw(scene);
    }
    return worst_ratio(actual, expected);
}

}  // namespace

void add_storage_cases(std::vector<StabilityCase>& table)
{
    table.push_back(
        {.group = 8,
         .name = "banding",
         .shows = "largest difference of a smooth gradient, T and radiance, from the frame in "
                  "rgba32f",
         .bound = kScreenStep,
         .unit = "of the value",
         .reason = "1/255: steps of the format that are larger than an 8-bit screen's own show as "
                   "bands",
         .asks = kTargetFormat,
         .runs = [](const StabilitySubject& subject) { return !has_long_floats(subject); },
         .measure = banding});
    table.push_back({.group = 8,
                     .name = "gradient",
                     .shows = "largest error of a smooth gradient, T and radiance",
                     .bound = kScreenStep,
                     .unit = "of the value",
                     .reason = "1/255: less than a step of an 8-bit screen",
                     .asks = kTargetFormat,
                     .runs = has_long_floats,
                     .measure = gradient});
    table.push_back({.group = 8,
                     .name = "radiance-1e5",
                     .shows = "rms error of a slab of 0.9e5 to 1.7e5 W/m^2/sr",
                     .bound = kJustNoticed,
                     .unit = "of the mean",
                     .reason = "1 % of the mean, as anywhere: a format that ends below clips",
                     .asks = kTargetFormat,
                     .measure = bright});
    table.push_back({.group = 8,
                     .name = "overflow",
                     .shows = "values that are no colour, radiances of 1e5, 1e30 and 6e38",
                     .bound = 0,
                     .unit = "values",
                     .reason = "beyond its largest value a format may clip, not break",
                     .asks = kTargetFormat,
                     .measure = finite});
    for (const std::string_view format : {"r11g11b10f", "rgba16f", "rgba32f"})
        table.push_back(
            {.group = 8,
             .name = fmt::format("history-stall-{}", format),
             .shows = "largest trace of where the eye was 256 frames ago, at 5 % a frame",
             .bound = kScreenStep,
             .unit = "of the value",
             .reason = "1/255: 0.95^256 is 2e-6, so what is left above a screen's step is what the "
                       "format would not let go of",
             .quick = format == "rgba16f",
             .runs = has_froxels,
             .measure = [=](const StabilityBench& bench) { return stall(bench, format); }});
}

}  // namespace fumarole::study
