// Group 6: media that change faster than the steps, and how the error falls as steps double.

#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "study/stability_bench.h"

namespace fumarole::study {

namespace {

StabilityFigure transmittance_error(const StabilityBench& bench, const Scene& scene,
                                    const Settings& settings)
{
    return rms_over_mean(layer(bench.render(scene, settings, 0), &Still::transmittance),
                         true_transmittance(scene));
}

/// 2 cm thick, met at 3 to 10 degrees: 0.1 to 0.4 m along a ray. Haze to 40 m spreads the steps.
Scene sheet_scene(bool haze)
{
    Scene scene = bare_scene(32);
    scene.camera.position = {0, 0, 0.4};
    scene.camera.look_at = {0, -3.5, 0};
    scene.camera.vfov_deg = 7;
    BoxMedium sheet;
    sheet.min = {-40, -40, -0.02};
    sheet.max = {40, 1, 0};
    sheet.sigma_a = glm::vec3(5);
    scene.media = {sheet};
    if (haze) {
        BoxMedium air;
        air.min = {-40, -40, -3};
        air.max = {40, 1, 3};
        air.sigma_a = glm::vec3(1e-3f);
        scene.media.emplace_back(air);
    }
    return scene;
}

/// Two slabs with a gap between: the faces inside of the march's range are met by no step.
Scene edge_scene()
{
    Scene scene = bare_scene(48);
    BoxMedium near_slab = slab(4, 6), far_slab = slab(9, 11);
    near_slab.sigma_a = far_slab.sigma_a = glm::vec3(0.4f);
    scene.media = {near_slab, far_slab};
    return scene;
}

/// Fog that falls off over 4 scale heights, smooth, seen from above.
Scene smooth_scene()
{
    Scene scene = bare_scene(24);
    scene.camera.position = {0, 0, 5};
    scene.camera.look_at = {0, -2, 0};
    BoxMedium fog;
    fog.min = {-3, -5, 0};
    fog.max = {3, 1, 4};
    fog.sigma_a = {1, 0.5f, 0.25f};
    fog.profile = ExpHeightProfile{.scale_height = 1, .z0 = 0};
    scene.media = {fog};
    return scene;
}

/// Largest error of the optical depth.
StabilityFigure edge_depth(const StabilityBench& bench, const Settings& settings)
{
    const Scene scene = edge_scene();
    const Picture t = layer(bench.render(scene, settings, 0), &Still::transmittance);
    const Picture truth = true_transmittance(scene);
    StabilityFigure figure = worst_difference(t, truth);
    figure.value = worst_ratio(t, truth).value;
    return figure;
}

StabilityFigure edge_bias(const StabilityBench& bench)
{
    const Scene scene = edge_scene();
    return mean_ratio(layer(bench.render(scene), &Still::transmittance), true_transmittance(scene));
}

StabilityFigure order(const StabilityBench& bench, const Scene& scene,
                      const std::vector<int>& steps)
{
    std::vector<double> errors;
    StabilityFigure figure;
    for (const int n : steps) {
        figure = transmittance_error(bench, scene, bench.march_alone(n));
        errors.push_back(figure.value);
    }
    // Where even the fewest steps leave what 32-bit sums round, more can't leave less.
    constexpr double kRounding = 1e-5;
    figure.value = errors.front() < kRounding ? std::numeric_limits<double>::infinity()
                                              : fitted_order(steps, errors);
    return figure;
}

}  // namespace

void add_march_cases(std::vector<StabilityCase>& table)
{
    const std::string notice(kNoticeReason);
    for (const bool haze : {false, true})
        table.push_back({.group = 6,
                         .name = haze ? "grazing-sheet-in-haze" : "grazing-sheet",
                         .shows = fmt::format("rms error of T of a 2 cm sheet at 3 to 10 degrees{}",
                                              haze ? ", in thin haze that reaches 40 m" : ""),
                         .bound = kJustNoticed,
                         .unit = "of the mean",
                         .reason = notice,
                         .measure = [haze](const StabilityBench& bench) {
                             return transmittance_error(bench, sheet_scene(haze), bench.settings);
                         }});
    table.push_back({.group = 6,
                     .name = "step-edge",
                     .shows = "largest error of T behind two slabs with a gap, without jitter",
                     .bound = kJustNoticed,
                     .unit = "of T",
                     .reason = notice,
                     .measure = [](const StabilityBench& bench) {
                         return edge_depth(bench, bench.march_alone());
                     }});
    table.push_back({.group = 6,
                     .name = "step-edge-bias",
                     .shows = "error of the picture's mean T behind them, as rendered",
                     .bound = 1e-3,
                     .unit = "of the mean",
                     .reason = "a tenth of what is just noticed: jitter may turn the edges' error "
                               "into noise, but noise has no mean",
                     .measure = edge_bias});
    table.push_back({.group = 6,
                     .name = "order-smooth",
                     .shows = "order of convergence of T from 16 to 256 steps, smooth fog",
                     .sense = StabilityCase::Bound::at_least,
                     .bound = 1.9,
                     .unit = "",
                     .reason =
                         "a midpoint rule is of order 2 where the medium is smooth; 1.9 leaves "
                         "room for a fit over five points",
                     .measure = [](const StabilityBench& bench) {
                         return order(bench, smooth_scene(), {16, 32, 64, 128, 256});
                     }});
    const std::string first_order =
        "a step that straddles an edge is wrong by its own length, which is order 1; 0.9 leaves "
        "room for a fit over five points";
    table.push_back({.group = 6,
                     .name = "order-step-edge",
                     .shows = "order of convergence of T from 16 to 256 steps, two slabs and a gap",
                     .sense = StabilityCase::Bound::at_least,
                     .bound = 0.9,
                     .unit = "",
                     .reason = first_order,
                     .measure = [](const StabilityBench& bench) {
                         return order(bench, edge_scene(), {16, 32, 64, 128, 256});
                     }});
    table.push_back({.group = 6,
                     .name = "order-grazing-sheet",
                     .shows = "order of convergence of T from 64 to 1024 steps, the sheet in haze",
                     .sense = StabilityCase::Bound::at_least,
                     .bound = 0.9,
                     .unit = "",
                     .reason = first_order,
                     .quick = false,
                     .measure = [](const StabilityBench& bench) {
                         return order(bench, sheet_scene(true), {64, 128, 256, 512, 1024});
                     }});
}

}  // namespace fumarole::study
