// Groups 4 and 5: where the scene's depth jumps, and where it is at an end of its range.

#include <cmath>
#include <fmt/format.h>

#include "study/stability_bench.h"

namespace fumarole::study {

namespace {

/// The eye in fog that reaches farther than any depth.
Scene fog_scene(int size, float sigma_a)
{
    Scene scene = bare_scene(size);
    BoxMedium fog;
    fog.min = {-60, -60, -60};
    fog.max = {60, 2, 60};
    fog.sigma_a = glm::vec3(sigma_a);
    scene.media = {fog};
    return scene;
}

// -- 4: edges ------------------------------------------------------------------------------------

/// Where the nearer of two depths is.
struct Pattern {
    std::string_view name, words;
    bool (*is_near)(int x, int y);
};

constexpr std::array kPatterns{
    Pattern{"wire", "an upright wire of a pixel", [](int x, int) { return x == 13; }},
    Pattern{"slanted-wire", "a slanted wire of a pixel",
            [](int x, int y) { return (3 * x + y) / 3 == 20; }},
    Pattern{"checkerboard", "depth that alternates from pixel to pixel",
            [](int x, int y) { return ((x ^ y) & 1) != 0; }},
    Pattern{"foliage", "foliage-like spots of pixels",
            [](int x, int y) { return ((x * 7 + y * 13 + x * y + 65) % 5) < 2; }},
    Pattern{"silhouette", "the silhouette of a disc",
            [](int x, int y) { return (x - 15) * (x - 15) + (y - 17) * (y - 17) < 90; }},
    Pattern{"lone-pixels", "lone near pixels",
            [](int x, int y) { return (x + 9) % 9 == 4 && (y + 7) % 7 == 3; }},
};

/// Mean error of T in units of the step between both sides: what spills over the edges. The pattern
/// is moved by `shift` pixels.
StabilityFigure shifted_halo(const StabilityBench& bench, const Settings& settings,
                             const Pattern& pattern, glm::ivec2 shift)
{
    constexpr double kNear = 2, kFar = 20, kSigma = 0.2;
    const Scene scene = fog_scene(32, static_cast<float>(kSigma));
    const auto view_z = [&](int x, int y) {
        return pattern.is_near(x - shift.x, y - shift.y) ? kNear : kFar;
    };
    const Picture actual = bench.over_white(scene, settings, view_z);
    Picture expected{32, 32, {}};
    double energy = 0;
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 32; ++x) {
            const double length = (view_z(x, y) - scene.camera.near) *
                                  pixel_ray(scene, {x + 0.5, y + 0.5}).length_per_z;
            const double t = std::exp(-kSigma * length);
            expected.rgb.insert(expected.rgb.end(), 3, static_cast<float>(t));
            energy += std::abs(double(actual.at(x, y).r) - t) / 1024;
        }
    StabilityFigure figure = worst_difference(actual, expected);
    figure.value = energy / (std::exp(-kSigma * kNear) - std::exp(-kSigma * kFar));
    return figure;
}

/// The worst of the ways in which the pattern may lie over the layer's texels, `edge` pixels wide;
/// over froxels, of some.
StabilityFigure halo(const StabilityBench& bench, const Settings& settings, const Pattern& pattern,
                     int edge)
{
    StabilityFigure worst;
    for (int y = 0; y < edge; ++y)
        for (int x = 0; x < edge; ++x)
            worst = worse(worst, shifted_halo(bench, settings, pattern, {x, y}));
    return worst;
}

// -- 5: ends of the range ------------------------------------------------------------------------

StabilityFigure sky(const StabilityBench& bench)
{
    Scene scene = bare_scene(32);
    BoxMedium box = slab(30, 50);
    box.sigma_a = {0.01f, 0.05f, 0.2f};
    scene.media = {box};
    const Picture truth =
        evaluate(scene, [&](const PixelRay& ray) { return box_transmittance(scene, ray, box); });
    return worst_difference(bench.over_white(scene, bench.settings, [](int, int) { return 0; }),
                            truth);
}

/// The far plane lies before the medium's end; what is sky is still farther.
StabilityFigure sky_past_far(const StabilityBench& bench)
{
    Scene scene = bare_scene(32);
    scene.camera.far = 40;
    BoxMedium box = slab(30, 50);
    box.sigma_a = {0.01f, 0.05f, 0.2f};
    scene.media = {box};
    const Picture truth =
        evaluate(scene, [&](const PixelRay& ray) { return box_transmittance(scene, ray, box); });
    return worst_difference(bench.over_white(scene, bench.settings, [](int, int) { return 0; }),
                            truth);
}

StabilityFigure depth_at_near(const StabilityBench& bench)
{
    const Scene scene = fog_scene(32, 1.0f);
    const Picture white = evaluate(scene, [](const PixelRay&) { return glm::dvec3(1); });
    return worst_difference(
        bench.over_white(scene, bench.settings, [&](int, int) { return scene.camera.near; }),
        white);
}

StabilityFigure wall_in_fog(const StabilityBench& bench)
{
    StabilityFigure worst;
    for (const double distance : {0.5, 3.0, 12.0, 40.0}) {
        const Scene scene = fog_scene(32, static_cast<float>(1 / distance));
        const Picture truth = evaluate(scene, [&](const PixelRay& ray) {
            return glm::dvec3(
                std::exp(-(distance - scene.camera.near) * ray.length_per_z / distance));
        });
        const Picture actual =
            bench.over_white(scene, bench.settings, [&](int, int) { return distance; });
        worst = worse(worst, worst_difference(actual, truth));
    }
    return worst;
}

/// A cloud behind the eye, or beside the view, takes its share of the sun from what is in view.
StabilityFigure shade_from(const StabilityBench& bench, bool behind)
{
    Scene scene = bare_scene(16);
    BoxMedium fog;
    fog.min = {-12, -20, -12};
    fog.max = {12, -4, 12};
    fog.sigma_s = glm::vec3(0.05f);
    scene.media = {fog};
    scene.lights = {SunLight{behind ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0), glm::vec3(3)}};
    Picture expected = layer(bench.render(scene), &Still::scattering);
    BoxMedium cloud;
    cloud.min = behind ? glm::dvec3(-20, 10, -20) : glm::dvec3(14, -22, -20);
    cloud.max = behind ? glm::dvec3(20, 11.5, 20) : glm::dvec3(15.5, -2, 20);
    cloud.sigma_a = {0.5f, 1.0f, 2.0f};
    scene.media.emplace_back(cloud);
    for (std::size_t i = 0; i < expected.rgb.size(); ++i)
        expected.rgb[i] *=
            static_cast<float>(std::exp(-1.5 * double(cloud.sigma_a[static_cast<int>(i % 3)])));
    return rms_over_mean(layer(bench.render(scene), &Still::scattering), expected);
}

}  // namespace

void add_depth_cases(std::vector<StabilityCase>& table)
{
    const std::string spill =
        "1 % of the edge's contrast over the whole picture, a third of which are edges: more shows "
        "as glow round leaves and wires";
    for (const std::string resolution : {"half", "quarter"})
        for (const Pattern& pattern : kPatterns)
            table.push_back(
                {.group = 4,
                 .name = fmt::format("{}-{}", pattern.name, resolution),
                 .shows = fmt::format("halo of {} at {}: mean error of T over the step",
                                      pattern.words, resolution == "half" ? "1/2" : "1/4"),
                 .bound = 0.01,
                 .unit = "of the step",
                 .reason = spill,
                 .runs = marches,
                 .measure = [=](const StabilityBench& bench) {
                     const Settings settings = bench.with("resolution", resolution);
                     return halo(bench, settings, pattern, settings.resolution);
                 }});
    for (const Pattern& pattern : kPatterns)
        table.push_back({.group = 4,
                         .name = fmt::format("{}-froxels", pattern.name),
                         .shows = fmt::format(
                             "halo of {} in froxels: mean error of T over the step", pattern.words),
                         .bound = 0.01,
                         .unit = "of the step",
                         .reason = spill,
                         .runs = has_froxels,
                         .measure = [=](const StabilityBench& bench) {
                             return halo(bench, bench.settings, pattern, 2);
                         }});
    for (const Pattern& pattern : {kPatterns[2], kPatterns[3]})
        table.push_back({.group = 4,
                         .name = fmt::format("{}-half-4x4", pattern.name),
                         .shows = fmt::format("the same at 1/2 with the 4x4 tent"),
                         .bound = 0.01,
                         .unit = "of the step",
                         .reason = spill,
                         .runs = [](const StabilitySubject& s) { return s.preset == "default"; },
                         .measure =
                             [=](const StabilityBench& bench) {
                                 Settings settings = bench.with("upsample", "4x4");
                                 settings.resolution = 2;
                                 return halo(bench, settings, pattern, settings.resolution);
                             }});

    const std::string screen(kScreenReason);
    const auto add = [&](std::string name, std::string shows,
                         StabilityFigure (*measure)(const StabilityBench&)) {
        table.push_back({.group = 5,
                         .name = std::move(name),
                         .shows = std::move(shows),
                         .bound = kScreenStep,
                         .unit = "of T",
                         .reason = screen,
                         .measure = measure});
    };
    add("sky", "largest error of T of a slab before the sky (depth 1)", sky);
    add("sky-past-far", "the same where the far plane cuts the slab", sky_past_far);
    add("depth-at-near", "largest error of T = 1 where depth is the near plane", depth_at_near);
    add("camera-inside", "largest error of T from within fog to walls at 0.5 to 40 m", wall_in_fog);
    for (const bool behind : {true, false})
        table.push_back({.group = 5,
                         .name = behind ? "shade-from-behind" : "shade-from-the-side",
                         .shows = fmt::format("rms error of the shade of a cloud {}",
                                              behind ? "behind the camera" : "beside the view"),
                         .bound = kJustNoticed,
                         .unit = "of the mean",
                         .reason = std::string(kNoticeReason),
                         .measure = [behind](const StabilityBench& bench) {
                             return shade_from(bench, behind);
                         }});
}

}  // namespace fumarole::study
