// Group 1: optical depth and emission at their ends, against closed forms.

#include <algorithm>
#include <cmath>

#include "study/stability_bench.h"

namespace fumarole::study {

namespace {

constexpr std::array kDepths{1e-6, 1e-4, 1e-2, 1.0, 30.0, 1e3, 1e4};

/// 2 m thick, 4 m ahead: sigma is the optical depth by 2 m.
constexpr double kNear = 4, kThick = 2;

template <class Measure> StabilityFigure over_depths(const Measure& measure)
{
    StabilityFigure worst;
    for (const double tau : kDepths)
        worst = worse(worst, measure(tau));
    return worst;
}

StabilityFigure transmittance(const StabilityBench& bench)
{
    return over_depths([&](double tau) {
        Scene scene = bare_scene(32);
        BoxMedium box = slab(kNear, kNear + kThick);
        box.sigma_a = glm::vec3(static_cast<float>(tau / kThick)) * glm::vec3(1, 0.5f, 0.1f);
        scene.media = {box};
        const Picture truth = evaluate(
            scene, [&](const PixelRay& ray) { return box_transmittance(scene, ray, box); });
        return worst_difference(layer(bench.render(scene), &Still::transmittance), truth);
    });
}

/// Emission that makes a radiance of about 1 whatever the extinction.
StabilityFigure emission(const StabilityBench& bench)
{
    return over_depths([&](double tau) {
        Scene scene = bare_scene(32);
        BoxMedium box = slab(kNear, kNear + kThick);
        const double sigma = tau / kThick;
        box.sigma_a = glm::vec3(static_cast<float>(sigma));
        box.emission = glm::vec3(static_cast<float>(sigma / -std::expm1(-tau)));
        scene.media = {box};
        const Picture truth = evaluate(scene, [&](const PixelRay& ray) {
            return glm::dvec3(double(box.emission.r) *
                              -std::expm1(-sigma * length_in(scene, ray, box)) / sigma);
        });
        return rms_over_mean(layer(bench.render(scene), &Still::scattering), truth);
    });
}

StabilityFigure emission_alone(const StabilityBench& bench)
{
    Scene scene = bare_scene(32);
    BoxMedium box = slab(kNear, kNear + kThick);
    box.emission = {0.5f, 0.1f, 0.02f};
    scene.media = {box};
    const Picture truth = evaluate(scene, [&](const PixelRay& ray) {
        return glm::dvec3(box.emission) * length_in(scene, ray, box);
    });
    return rms_over_mean(layer(bench.render(scene), &Still::scattering), truth);
}

Scene scene_with_a_clear_channel()
{
    Scene scene = bare_scene(32);
    BoxMedium box = slab(kNear, kNear + kThick);
    box.sigma_a = {0, 0.5f, 50.0f};
    box.emission = glm::vec3(0.5f);
    scene.media = {box};
    return scene;
}

/// The red channel of a picture, in all three.
Picture red(Picture picture)
{
    for (std::size_t i = 0; i < picture.rgb.size(); ++i)
        picture.rgb[i] = picture.rgb[i - i % 3];
    return picture;
}

StabilityFigure clear_channel(const StabilityBench& bench)
{
    const Scene scene = scene_with_a_clear_channel();
    const Picture one = evaluate(scene, [](const PixelRay&) { return glm::dvec3(1); });
    return worst_difference(red(layer(bench.render(scene), &Still::transmittance)), one);
}

StabilityFigure clear_channel_emission(const StabilityBench& bench)
{
    const Scene scene = scene_with_a_clear_channel();
    const auto& box = std::get<BoxMedium>(scene.media[0]);
    const Picture truth = evaluate(scene, [&](const PixelRay& ray) {
        return glm::dvec3(double(box.emission.r) * length_in(scene, ray, box));
    });
    return rms_over_mean(red(layer(bench.render(scene), &Still::scattering)), truth);
}

/// Albedo 1 in a white world that is not dimmed: what a ray loses it gains.
StabilityFigure furnace(const StabilityBench& bench)
{
    StabilityFigure worst;
    Settings settings = bench.settings;
    settings.ambient_volume_size = 0;  // light scattered once in a dimmed world is no furnace
    for (const bool grid : {false, true}) {
        Scene scene = bare_scene(32);
        scene.world.radiance = glm::vec3(1);
        BoxMedium box = slab(kNear, kNear + kThick);
        box.sigma_s = {0.1f, 1.0f, 10.0f};
        scene.media = {box};
        if (grid)
            scene.media = {lump(4, 0)};
        const Picture one = evaluate(scene, [](const PixelRay&) { return glm::dvec3(1); });
        worst = worse(worst, worst_difference(
                                 layer(bench.render(scene, settings, 0), &Still::composite), one));
    }
    return worst;
}

}  // namespace

void add_extinction_cases(std::vector<StabilityCase>& table)
{
    table.push_back({.group = 1,
                     .name = "slab-transmittance",
                     .shows = "largest error of T of a uniform slab, optical depths 1e-6 to 1e4",
                     .bound = kScreenStep,
                     .unit = "of T",
                     .reason = std::string(kScreenReason),
                     .measure = transmittance});
    table.push_back({.group = 1,
                     .name = "slab-emission",
                     .shows = "rms error of a glowing slab's radiance, optical depths 1e-6 to 1e4",
                     .bound = kJustNoticed,
                     .unit = "of the mean",
                     .reason = std::string(kNoticeReason),
                     .measure = emission});
    table.push_back({.group = 1,
                     .name = "emission-alone",
                     .shows = "rms error of a slab that glows and takes nothing",
                     .bound = kJustNoticed,
                     .unit = "of the mean",
                     .reason = std::string(kNoticeReason),
                     .measure = emission_alone});
    table.push_back(
        {.group = 1,
         .name = "clear-channel",
         .shows = "largest error of T = 1 in a channel of zero extinction beside others",
         .bound = kHalfFloat,
         .unit = "of T",
         .reason = std::string(kHalfReason) + "; nothing else may touch it",
         .measure = clear_channel});
    table.push_back({.group = 1,
                     .name = "clear-channel-emission",
                     .shows = "rms error of the radiance of that channel",
                     .bound = kJustNoticed,
                     .unit = "of the mean",
                     .reason = std::string(kNoticeReason),
                     .measure = clear_channel_emission});
    table.push_back({.group = 1,
                     .name = "white-furnace",
                     .shows = "largest error of 1: albedo 1 in and before a white world, undimmed",
                     .bound = 2 * kHalfFloat,
                     .unit = "of the radiance",
                     .reason = "2 * 2^-11: T and scattering are stored, each rounded to 16 bits, "
                               "and must add up to 1",
                     .measure = furnace});
}

}  // namespace fumarole::study
