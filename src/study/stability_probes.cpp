// Group 3, probes: where they stand badly, how they meet each other, and how they follow light that
// changes.

#include <algorithm>
#include <cmath>

#include "study/stability_bench.h"

namespace fumarole::study {

namespace {

/// What differs between presets draws no surface.
bool is_default_march(const StabilitySubject& subject)
{
    return subject.preset == "default";
}

LightProbe small_probe(glm::dvec3 position)
{
    LightProbe probe;
    probe.position = position;
    probe.radius = 12;
    probe.falloff = 0.2;
    probe.size = 16;
    return probe;
}

/// A mirror ball before a wall, seen from the origin, and a lamp that shines on a wall behind it.
Scene probe_scene(float roughness)
{
    Scene scene = bare_scene(24);
    SphereSurface ball;
    ball.center = {0, -5, 0};
    ball.radius = 1;
    ball.albedo = glm::vec3(0.9f);
    ball.gloss = Gloss{.roughness = roughness, .metallic = 1};
    scene.surfaces = {ball, BoxSurface{{-6, -9, -3}, {6, -8, 3}, glm::vec3(0.6f)},
                      BoxSurface{{-7, -8, -3}, {-6, 2, 3}, glm::vec3(0.7f, 0.2f, 0.1f)},
                      BoxSurface{{6, -8, -3}, {7, 2, 3}, glm::vec3(0.7f)}};
    scene.lights = {SpotLight{{3, -2, 0}, {1, 0, 0}, 60, 0.1, glm::vec3(40)}};
    scene.world.radiance = glm::vec3(0.2f);
    scene.probes = {small_probe({1.6, -4, 0.4})};
    return scene;
}

StabilityFigure bad_of_both(const StabilityBench& bench, const std::function<void(Scene&)>& change)
{
    StabilityFigure bad;
    for (const float roughness : {0.0f, 1.0f}) {
        Scene scene = probe_scene(roughness);
        change(scene);
        bad = worse(bad, count_bad(bench.render(scene)));
    }
    return bad;
}

StabilityFigure inside_a_surface(const StabilityBench& bench)
{
    StabilityFigure bad;
    for (const glm::dvec3 place : {glm::dvec3(0.1, -5, 0), glm::dvec3(6.5, -4, 0)})
        bad =
            worse(bad, bad_of_both(bench, [&](Scene& scene) { scene.probes[0].position = place; }));
    return bad;
}

StabilityFigure inside_smoke(const StabilityBench& bench)
{
    return bad_of_both(bench, [](Scene& scene) {
        BoxMedium smoke;
        smoke.min = {1.2, -6, -2};
        smoke.max = {3, -3, 2};
        smoke.sigma_s = glm::vec3(300);
        scene.media = {smoke};
    });
}

StabilityFigure under_a_sun(const StabilityBench& bench)
{
    auto map = std::make_shared<Environment>();
    map->width = 32;
    map->height = 16;
    map->radiance.assign(std::size_t(32) * 16, glm::vec3(0));
    map->radiance[3 * 32 + 5] = glm::vec3(1e5f);
    return bad_of_both(bench, [&](Scene& scene) { scene.world.environment = map; });
}

/// Light where there is none.
StabilityFigure black_world(const StabilityBench& bench)
{
    StabilityFigure most;
    for (const float roughness : {0.0f, 1.0f}) {
        Scene scene = probe_scene(roughness);
        scene.world.radiance = glm::vec3(0);
        scene.lights.clear();
        const Picture picture = layer(bench.render(scene), &Still::composite);
        Picture dark = picture;
        dark.rgb.assign(dark.rgb.size(), 0.0f);
        most = worse(most, worst_difference(picture, dark));
    }
    return most;
}

/// As many as there may be, all in one place, are one. With a medium, or they would light surfaces,
/// and the later ones of a turn see what the earlier ones do.
StabilityFigure sixteen(const StabilityBench& bench)
{
    Scene scene = probe_scene(0.1f);
    BoxMedium haze;
    haze.min = {-1, -7, 1.5};
    haze.max = {1, -4, 2.5};
    haze.sigma_s = glm::vec3(0.01f);
    scene.media = {haze};
    const Picture one = layer(bench.render(scene), &Still::composite);
    scene.probes.assign(16, scene.probes[0]);
    return worst_difference(layer(bench.render(scene), &Still::composite), one);
}

/// A glossy ground across the edges of two probes: what neighbouring pixels differ by, over what
/// they would if a probe's weight rose evenly over its falloff.
StabilityFigure influence_edges(const StabilityBench& bench)
{
    Scene scene = probe_scene(0.5f);
    BoxSurface ground{{-6, -8, -2}, {6, 2, -1}, glm::vec3(0.9f)};
    ground.gloss = Gloss{.roughness = 0.5f, .metallic = 1};
    scene.surfaces[0] = ground;
    scene.camera.position = {0, -4, 12};
    scene.camera.look_at = {0, -4, 0};
    scene.camera.up = {0, 1, 0};
    scene.probes[0].radius = 2.5;
    scene.probes[0].falloff = 0.5;
    scene.probes.push_back(scene.probes[0]);
    scene.probes[1].position.x = -2;
    const Picture with = layer(bench.render(scene), &Still::composite);
    scene.probes.clear();
    const Picture without =
        layer(bench.render(scene, bench.with("probes", "off"), 0), &Still::composite);
    // Of what probes change, from pixel to pixel along rows.
    double largest = 0, steepest = 0;
    const auto change = [&](int x, int y) {
        return glm::dvec3(with.at(x, y)) - glm::dvec3(without.at(x, y));
    };
    for (int y = 0; y < with.height; ++y)
        for (int x = 0; x < with.width; ++x) {
            largest = std::max(largest, glm::length(change(x, y)));
            if (x > 0)
                steepest = std::max(steepest, glm::length(change(x, y) - change(x - 1, y)));
        }
    StabilityFigure figure = worst_difference(with, without);
    constexpr double kHeight = 13, kFalloff = 1.25;  // metres
    const double even = 2 * kHeight * std::tan(glm::radians(20.0)) / with.width / kFalloff;
    figure.value = steepest / largest / even;
    return figure;
}

/// A lamp that is switched to another wall: the largest step of a frame, of the whole change that a
/// mirror shows.
StabilityFigure moved_light(const StabilityBench& bench)
{
    Scene scene = probe_scene(0.1f);
    StabilityView view(bench, bench.settings);
    view.set_scene(scene);
    constexpr int kSettled = 24;
    for (int i = 0; i < kSettled; ++i)
        view.draw(scene);
    const Picture before = view.draw(scene);
    std::get<SpotLight>(scene.lights[0]).direction = {-1, 0, 0};
    std::get<SpotLight>(scene.lights[0]).position = {-3, -2, 0};
    view.set_scene(scene);
    std::vector<Picture> frames{before};
    for (int i = 0; i < kSettled; ++i)
        frames.push_back(view.draw(scene));
    // The ball's pixels: the lamp lights none of it.
    const int middle = before.width / 2;
    const auto shown = [&](const Picture& picture) {
        glm::dvec3 sum(0);
        for (int y = middle - 2; y <= middle + 2; ++y)
            for (int x = middle - 2; x <= middle + 2; ++x)
                sum += glm::dvec3(picture.at(x, y));
        return sum;
    };
    const double whole = glm::length(shown(frames.back()) - shown(before));
    StabilityFigure figure = worst_difference(frames.back(), before);
    figure.value = 0;
    for (std::size_t i = 1; i < frames.size(); ++i)
        figure.value =
            std::max(figure.value, glm::length(shown(frames[i]) - shown(frames[i - 1])) / whole);
    return figure;
}

}  // namespace

void add_probe_cases(std::vector<StabilityCase>& table)
{
    const auto add = [&](const char* name, const char* shows, double bound, const char* unit,
                         const char* reason,
                         StabilityFigure (*measure)(const StabilityBench& bench)) {
        table.push_back({.group = 3,
                         .name = name,
                         .shows = shows,
                         .bound = bound,
                         .unit = unit,
                         .reason = reason,
                         .runs = is_default_march,
                         .measure = measure});
    };
    const char* const finite = "one NaN spreads over its neighbours, and an infinity is one soon";
    add("probe-in-a-surface", "values that are no colour: a probe in a ball, and one in a wall", 0,
        "values", finite, inside_a_surface);
    add("probe-in-smoke", "values that are no colour: a probe in smoke of 300/m", 0, "values",
        finite, inside_smoke);
    add("probe-under-a-sun", "values that are no colour: probes under a map with a sun of 1e5", 0,
        "values", finite, under_a_sun);
    add("probe-black-world", "light on mirrors and rough metal with probes where there is none", 0,
        "W/m^2/sr", "no light is made", black_world);
    add("probes-16", "sixteen probes in one place against one of them", 1e-5, "W/m^2/sr",
        "their sum is the same to what rounding leaves", sixteen);
    add("probe-edges",
        "steepest change across the edges of two probes, over that of a weight that rises evenly",
        2, "times", "the weights of two meet, and what they cover is shared; a jump is 3.2",
        influence_edges);
    add("probe-moved-light",
        "largest change of a mirror from frame to frame after a lamp was moved, of all of it", 0.2,
        "of the change", "what is new fades in over 8 frames, the second turn within them",
        moved_light);
}

}  // namespace fumarole::study
