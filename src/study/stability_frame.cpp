// Group 9: sizes, corners, far fog, walls.

#include <cmath>
#include <fmt/format.h>

#include "study/stability_bench.h"

namespace fumarole::study {

namespace {

/// A slab seen by parallel rays: one T everywhere, whatever the size.
Scene level_scene(glm::uvec2 size)
{
    Scene scene = bare_scene(1);
    scene.resolution = size;
    scene.camera.projection = Camera::Projection::orthographic;
    scene.camera.ortho_height = 3;
    BoxMedium box = slab(4, 6);
    box.sigma_a = {0.1f, 0.5f, 2.0f};
    scene.media = {box};
    return scene;
}

constexpr std::array kSizes{glm::uvec2(1, 1), glm::uvec2(3, 5),  glm::uvec2(33, 17),
                            glm::uvec2(2, 1), glm::uvec2(64, 1), glm::uvec2(31, 32)};

StabilityFigure odd_sizes(const StabilityBench& bench)
{
    StabilityFigure worst;
    for (const glm::uvec2 size : kSizes)
        for (const Settings& settings : bench.small_layers()) {
            const Scene scene = level_scene(size);
            const auto& box = std::get<BoxMedium>(scene.media[0]);
            const Picture truth = evaluate(
                scene, [&](const PixelRay& ray) { return box_transmittance(scene, ray, box); });
            const Still still = bench.render(scene, settings, 0);
            worst = worse(worst, worst_difference(layer(still, &Still::transmittance), truth));
        }
    return worst;
}

StabilityFigure changing_sizes(const StabilityBench& bench)
{
    const auto draw = [&](glm::uvec2 size) {
        Scene scene = bare_scene(1);
        scene.resolution = size;
        scene.media = {lump(2, 1)};
        scene.lights = {SunLight{{0.7, 0.3, 0.6}, glm::vec3(4)}};
        return layer(bench.render(scene), &Still::composite);
    };
    const Picture first = draw({37, 21});
    StabilityFigure worst;
    for (const glm::uvec2 size : kSizes) {
        (void)draw(size);
        worst = worse(worst, worst_difference(draw({37, 21}), first));
    }
    return worst;
}

/// What a view of one size kept must not be found in one of another.
StabilityFigure changing_sizes_history(const StabilityBench& bench)
{
    Scene scene = bare_scene(1);
    scene.media = {lump(2, 1)};
    scene.lights = {SunLight{{0.7, 0.3, 0.6}, glm::vec3(4)}};
    Settings settings = bench.settings;
    settings.jitter = Settings::Jitter::none;  // so that frames may be compared
    StabilityView view(bench, settings);
    view.set_scene(scene);
    constexpr glm::uvec2 kSize(37, 21);
    const Picture first = view.draw(scene.camera, kSize);
    StabilityFigure worst;
    for (const glm::uvec2 size : kSizes) {
        (void)view.draw(scene.camera, size);
        worst = worse(worst, worst_difference(view.draw(scene.camera, kSize), first));
    }
    return worst;
}

/// 90 degrees high: the corner's ray is 1.7 times as long as the middle's. At 1/2 and 1/4, where
/// the outermost texels lie inside of the outermost pixels.
StabilityFigure corners(const StabilityBench& bench)
{
    Scene scene = bare_scene(64);
    scene.camera.vfov_deg = 90;
    BoxMedium box = slab(4, 6);
    box.sigma_a = {0.1f, 0.3f, 0.5f};
    scene.media = {box};
    StabilityFigure worst;
    for (const Settings& settings : bench.small_layers()) {
        const Still still = bench.render(scene, settings, 0);
        Picture actual{2, 2, {}}, expected{2, 2, {}};
        for (const int y : {0, 63})
            for (const int x : {0, 63}) {
                const glm::vec3 a = layer(still, &Still::transmittance).at(x, y);
                const glm::vec3 e(
                    box_transmittance(scene, pixel_ray(scene, {x + 0.5, y + 0.5}), box));
                actual.rgb.insert(actual.rgb.end(), {a.r, a.g, a.b});
                expected.rgb.insert(expected.rgb.end(), {e.r, e.g, e.b});
            }
        worst = worse(worst, worst_difference(actual, expected));
    }
    return worst;
}

StabilityFigure far_fog(const StabilityBench& bench)
{
    StabilityFigure worst;
    for (const double far : {1e3, 1e4, 1e5}) {
        Scene scene = bare_scene(32);
        scene.camera.far = 2 * far;
        BoxMedium fog;
        fog.min = glm::dvec3(-far);
        fog.max = glm::dvec3(far);
        fog.sigma_a = glm::vec3(glm::vec3(1, 0.3f, 0.1f) / static_cast<float>(far));
        scene.media = {fog};
        const Picture truth = evaluate(
            scene, [&](const PixelRay& ray) { return box_transmittance(scene, ray, fog); });
        worst = worse(worst,
                      worst_difference(layer(bench.render(scene), &Still::transmittance), truth));
    }
    return worst;
}

/// A wall of 5 cm with a bright light behind it: fog on this side stays dark.
StabilityFigure thin_wall(const StabilityBench& bench)
{
    Scene scene = bare_scene(32);
    BoxMedium fog;
    fog.min = {-8, -12, -8};
    fog.max = {8, 2, 8};
    fog.sigma_s = glm::vec3(0.2f);
    scene.media = {fog};
    scene.lights = {PointLight{{0, -6, 0}, glm::vec3(10)}};
    const Picture open = layer(bench.render(scene), &Still::scattering);
    scene.surfaces = {BoxSurface{{-20, -5.05, -20}, {20, -5, 20}, glm::vec3(0)}};
    const Picture closed = layer(bench.render(scene), &Still::scattering);
    Picture dark = closed;
    dark.rgb.assign(dark.rgb.size(), 0.0f);
    StabilityFigure figure = worst_difference(closed, dark);
    figure.value = closed.mean() / open.mean();
    return figure;
}

/// The medium's own edge, askew to the pixels: no depth edge says where it is.
StabilityFigure misaligned_edge(const StabilityBench& bench, const Settings& settings)
{
    Scene scene = bare_scene(64);
    scene.camera.position = {4, 3, 2.5};
    BoxMedium box;
    box.min = {-0.5, -0.7, -0.6};
    box.max = {0.6, 0.4, 0.5};
    box.sigma_a = {0.3f, 1.0f, 3.0f};
    scene.camera.look_at = (box.min + box.max) / 2.0;
    scene.media = {box};
    const Picture truth =
        evaluate(scene, [&](const PixelRay& ray) { return box_transmittance(scene, ray, box); });
    return rms_over_mean(layer(bench.render(scene, settings, 0), &Still::transmittance), truth);
}

}  // namespace

void add_frame_cases(std::vector<StabilityCase>& table)
{
    const std::string screen(kScreenReason), notice(kNoticeReason);
    const auto add = [&](std::string name, std::string shows, double bound, std::string unit,
                         std::string reason, decltype(StabilityCase::measure) measure) {
        table.push_back({.group = 9,
                         .name = std::move(name),
                         .shows = std::move(shows),
                         .bound = bound,
                         .unit = std::move(unit),
                         .reason = std::move(reason),
                         .measure = std::move(measure)});
    };
    add("far-fog", "largest error of T of fog to 1, 10 and 100 km", kScreenStep, "of T", screen,
        far_fog);
    add("thin-wall", "light that comes through a wall of 5 cm, over what comes without it", 1e-3,
        "of the light", "a thousandth: dark fog beside a lit room is seen at far less than 1 %",
        thin_wall);
    add("misaligned-edge", "rms error of T of a box askew, as rendered", kJustNoticed,
        "of the mean", notice,
        [](const StabilityBench& bench) { return misaligned_edge(bench, bench.settings); });
    add("misaligned-edge-full", "the same at full size", kJustNoticed, "of the mean", notice,
        [](const StabilityBench& bench) { return misaligned_edge(bench, bench.full_size()); });
    add("odd-sizes", "largest error of T, 1x1 to 64x1 pixels at 1/2 and 1/4, or in froxels",
        kScreenStep, "of T", screen, odd_sizes);
    add("changing-sizes", "largest change of a picture after pictures of other sizes", 0,
        "of the radiance", "nothing of another size may be left over: the same bits",
        changing_sizes);
    add("corners", "largest error of T in the corners, 90 degrees, at 1/2 and 1/4, or in froxels",
        kScreenStep, "of T", screen, corners);
    add("changing-sizes-history", "largest change of a view's picture after frames of other sizes",
        0, "of the radiance", "a history of another size is none: the same bits",
        changing_sizes_history);
    table.back().runs = has_froxels;
}

}  // namespace fumarole::study
