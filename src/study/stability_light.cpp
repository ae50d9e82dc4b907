// Groups 2 and 3: narrow phase functions and lights inside the medium.

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "study/reference.h"
#include "study/reference_media.h"
#include "study/stability_bench.h"

namespace fumarole::study {

namespace {

Picture reference_scattering(const Scene& scene)
{
    ReferenceOptions options;
    options.tolerance = 1e-4;
    options.bounces = 0;
    return layer(render_reference(scene, options), &ReferenceStill::scattering);
}

// -- 2: the phase function -----------------------------------------------------------------------

/// The sun 5 degrees off the axis, in the picture, before (g > 0) or behind the eye.
Scene lobe_scene(float g)
{
    Scene scene = bare_scene(64);
    const glm::dvec3 in_view = glm::normalize(glm::dvec3(0.05, -1, 0.07));
    scene.lights = {SunLight{g > 0 ? in_view : -in_view, glm::vec3(1)}};
    BoxMedium box = slab(4, 6);
    box.sigma_s = {0.1f, 0.4f, 1.0f};
    box.sigma_a = glm::vec3(0.1f);
    box.g = g;
    scene.media = {box};
    return scene;
}

StabilityFigure lobe(const StabilityBench& bench, const Settings& settings, float g)
{
    StabilityFigure worst;
    for (const float sign : {1.0f, -1.0f}) {
        const Scene scene = lobe_scene(sign * g);
        const auto& box = std::get<BoxMedium>(scene.media[0]);
        const auto& sun = std::get<SunLight>(scene.lights[0]);
        const Picture truth =
            evaluate(scene, [&](const PixelRay& ray) { return sun_in_slab(scene, ray, box, sun); });
        const Still still = bench.render(scene, settings, 0);
        worst = worse(worst, rms_over_mean(layer(still, &Still::scattering), truth));
    }
    return worst;
}

/// The sun exactly along a pixel's ray. At full size, since only a pixel's own ray meets the peak,
/// which is a tenth of a pixel wide.
StabilityFigure peak(const StabilityBench& bench)
{
    Settings settings = bench.march_alone();
    settings.g_clamp = 0.999f;
    double worst = 0;
    for (const float sign : {1.0f, -1.0f})
        for (const glm::ivec2 at : {glm::ivec2(7, 7), {2, 11}, {13, 4}, {0, 14}}) {
            Scene scene = lobe_scene(sign);
            scene.resolution = glm::uvec2(15);
            const PixelRay ray = pixel_ray(scene, glm::dvec2(at) + 0.5);
            scene.lights = {SunLight{double(sign) * ray.direction, glm::vec3(1)}};
            auto& box = std::get<BoxMedium>(scene.media[0]);
            box.g = sign * 0.999f;
            const auto& sun = std::get<SunLight>(scene.lights[0]);
            const double expected = sun_in_slab(scene, ray, box, sun).g;
            const Still still = bench.render(scene, settings, 0);
            const double actual = layer(still, &Still::scattering).at(at.x, at.y).g;
            const double off = std::abs(actual / expected - 1);
            if (!(off <= worst))
                worst = off;
        }
    return {worst};
}

StabilityFigure finite_peak(const StabilityBench& bench)
{
    StabilityFigure bad;
    for (const float g : {0.999f, -0.999f, 0.99999f, -0.99999f})
        for (const double cut : {0.999, 0.9999}) {
            Scene scene = lobe_scene(g);
            scene.lights = {SunLight{{0, g > 0 ? -1 : 1, 0}, glm::vec3(1e5f)}};
            bad = worse(bad, count_bad(bench.render(
                                 scene, bench.with("g-clamp", fmt::format("{}", cut)), 0)));
        }
    return bad;
}

// -- 3: lights in the medium ---------------------------------------------------------------------

/// Fog all around, black world, a light at `position`.
Scene fog_scene(int size, glm::dvec3 position)
{
    Scene scene = bare_scene(size);
    BoxMedium fog;
    fog.min = {-8, -12, -8};
    fog.max = {8, 2, 8};
    fog.sigma_s = {0.05f, 0.1f, 0.3f};
    fog.sigma_a = {0.02f, 0.0f, 0.1f};
    fog.g = 0.5f;
    scene.media = {fog};
    scene.lights = {PointLight{position, {10, 8, 6}}};
    return scene;
}

/// A tenth of a pixel's width off a pixel's ray, 5 m ahead.
constexpr glm::dvec3 kNearRay(0.8, -5, 0.5);

StabilityFigure point_light(const StabilityBench& bench, const Settings& settings,
                            glm::dvec3 position)
{
    const Scene scene = fog_scene(16, position);
    return rms_over_mean(layer(bench.render(scene, settings, 0), &Still::scattering),
                         reference_scattering(scene));
}

StabilityFigure alone_at_steps(const StabilityBench& bench, int steps)
{
    return point_light(bench, bench.march_alone(steps), kNearRay);
}

/// A light so much brighter gives a picture so much brighter, as long as the format holds it.
StabilityFigure bright_light(const StabilityBench& bench)
{
    Scene scene = fog_scene(32, {0.8, -5, 0.5});
    const Picture once = layer(bench.render(scene), &Still::scattering);
    // Brightest value of one frame brought to 3e4: under the 16-bit formats' largest.
    const float most = *std::max_element(once.rgb.begin(), once.rgb.end());
    const float factor = 3e4f / most;
    auto& light = std::get<PointLight>(scene.lights[0]);
    light.radiant_intensity *= factor;
    Picture expected = once;
    for (float& v : expected.rgb)
        v *= factor;
    return worst_ratio(layer(bench.render(scene), &Still::scattering), expected);
}

StabilityFigure finite_lights(const StabilityBench& bench)
{
    StabilityFigure bad;
    const Scene aim = fog_scene(16, {});
    const std::array positions{
        aim.camera.position,               // on the camera
        glm::dvec3(0, -3, 0),              // on its axis
        pixel_ray(aim, {5.5, 9.5}).at(4),  // on a pixel's ray
        pixel_ray(aim, {6, 10}).at(4),     // on a half-size texel's ray
        glm::dvec3(0.2, -8, 0.1),          // on the surface
        glm::dvec3(8, 2, 8),               // on the medium's corner
    };
    for (const glm::dvec3 position : positions)
        for (const float g : {0.0f, 0.999f})
            for (const float sigma : {1e-6f, 0.5f, 1e3f}) {
                Scene scene = fog_scene(16, position);
                scene.surfaces = {BoxSurface{{-8, -9, -8}, {8, -8, 8}, glm::vec3(0.5f)}};
                scene.lights = {PointLight{position, glm::vec3(1e5f)},
                                SpotLight{position, {0, -1, 0}, 179.9, 0, glm::vec3(1e5f)}};
                auto& fog = std::get<BoxMedium>(scene.media[0]);
                fog.sigma_s = glm::vec3(sigma);
                fog.g = g;
                bad = worse(bad, count_bad(bench.render(scene)));
            }
    return bad;
}

/// A ground and a ball of the least and the most roughness, under every kind of light.
StabilityFigure finite_gloss(const StabilityBench& bench)
{
    StabilityFigure bad;
    for (const float roughness : {0.0f, 1.0f})
        for (const float metallic : {0.0f, 1.0f})
            for (const glm::dvec3 position : {glm::dvec3(0.2, -4.4, 0.1), glm::dvec3(0, -3, 40)}) {
                Scene scene = fog_scene(32, position);
                const Gloss gloss{.roughness = roughness, .metallic = metallic};
                scene.surfaces = {
                    SphereSurface{.center = {0.2, -5, 0.1}, .radius = 0.5, .gloss = gloss},
                    BoxSurface{.min = {-8, -12, -3}, .max = {8, 2, -1}, .gloss = gloss}};
                RectLight rect;
                rect.center = {0, -4, 1.5};
                rect.radiance = glm::vec3(1e5f);
                DiskLight disk;
                disk.center = {0, -5, -1};  // on the ground
                disk.radiance = glm::vec3(1e5f);
                disk.two_sided = true;
                scene.lights = {SunLight{glm::normalize(glm::dvec3(0, -1, 0.4)), glm::vec3(1e5f)},
                                PointLight{position, glm::vec3(1e5f)},
                                SpotLight{position, {0, -1, 0}, 179.9, 0, glm::vec3(1e5f)}, rect,
                                disk};
                bad = worse(bad, count_bad(bench.render(scene)));
            }
    return bad;
}

}  // namespace

void add_light_cases(std::vector<StabilityCase>& table)
{
    const std::string notice(kNoticeReason);
    for (const float g : {0.5f, 0.9f, 0.99f}) {
        const auto add = [&](std::string_view size, decltype(StabilityCase::runs) runs,
                             decltype(StabilityCase::measure) measure) {
            table.push_back({.group = 2,
                             .name = fmt::format("lobe-g-{}-{}", g, size),
                             .shows = fmt::format("rms error around a sun in view, worse of g {} "
                                                  "and -{}, {}",
                                                  g, g, size == "froxels" ? "as rendered" : size),
                             .bound = kJustNoticed,
                             .unit = "of the mean",
                             .reason = notice,
                             .runs = std::move(runs),
                             .measure = std::move(measure)});
        };
        add("half", marches, [g](const StabilityBench& bench) {
            return lobe(bench, bench.with("resolution", "half"), g);
        });
        add("froxels", has_froxels,
            [g](const StabilityBench& bench) { return lobe(bench, bench.settings, g); });
        add("full", {},
            [g](const StabilityBench& bench) { return lobe(bench, bench.full_size(), g); });
    }
    table.push_back({.group = 2,
                     .name = "peak-g-0.999",
                     .shows = "largest error of a pixel that looks straight at the sun, full size",
                     .bound = kJustNoticed,
                     .unit = "of the pixel",
                     .reason = notice + "; the peak is 2e6 times the mean, so it is what is seen",
                     .measure = peak});
    table.push_back({.group = 2,
                     .name = "peak-finite",
                     .shows = "values that are no colour, sun of 1e5 in view, g to +-0.99999",
                     .bound = 0,
                     .unit = "values",
                     .reason = "one NaN spreads over its neighbours, and an infinity is one soon",
                     .measure = finite_peak});

    table.push_back({.group = 3,
                     .name = "light-near-a-ray",
                     .shows = "rms error of fog around a point light 5 m ahead, as rendered",
                     .bound = kJustNoticed,
                     .unit = "of the mean",
                     .reason = notice,
                     .measure = [](const StabilityBench& bench) {
                         return point_light(bench, bench.settings, kNearRay);
                     }});
    for (const int steps : {64, 128, 256, 512})
        table.push_back({.group = 3,
                         .name = fmt::format("light-near-a-ray-{}-steps", steps),
                         .shows = fmt::format(
                             "the same at {} steps or slices, full size, without jitter", steps),
                         .bound = kJustNoticed,
                         .unit = "of the mean",
                         .reason = notice,
                         .quick = steps == 64 || steps == 256,
                         .measure = [steps](const StabilityBench& bench) {
                             return alone_at_steps(bench, steps);
                         }});
    table.push_back({.group = 3,
                     .name = "light-on-the-camera",
                     .shows = "rms error of fog with a point light on the eye, as rendered",
                     .bound = kJustNoticed,
                     .unit = "of the mean",
                     .reason = notice,
                     .measure = [](const StabilityBench& bench) {
                         return point_light(bench, bench.settings, {0, 0, 0});
                     }});
    table.push_back({.group = 3,
                     .name = "light-of-1e5-is-linear",
                     .shows = "largest difference of a light whose brightest pixel is 3e4 from a "
                              "weak one's picture times their ratio",
                     .bound = 2 * kHalfFloat,
                     .unit = "of the pixel",
                     .reason = "2 * 2^-11: both pictures round to 16 bits, nothing else may differ",
                     .measure = bright_light});
    table.push_back({.group = 3,
                     .name = "lights-finite",
                     .shows = "values that are no colour: lights of 1e5 on the camera, on rays, on "
                              "a surface, on the medium's corner",
                     .bound = 0,
                     .unit = "values",
                     .reason = "one NaN spreads over its neighbours, and an infinity is one soon",
                     .measure = finite_lights});
    table.push_back({.group = 3,
                     .name = "gloss-finite",
                     .shows = "values that are no colour: a ground and a ball of roughness 0 and "
                              "1, lacquer and metal, under every kind of light, each of 1e5",
                     .bound = 0,
                     .unit = "values",
                     .reason = "one NaN spreads over its neighbours, and an infinity is one soon",
                     .measure = finite_gloss});
}

}  // namespace fumarole::study
