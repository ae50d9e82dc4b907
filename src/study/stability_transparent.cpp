// Group 4 too: transparents in front of, in and behind media.

#include <array>
#include <cmath>
#include <fmt/format.h>

#include "study/stability_bench.h"

namespace fumarole::study {

namespace {

/// Smoke in a sun and haze before a grey wall, which panes are to stand in.
Scene pane_scene(int size = 48)
{
    Scene scene = bare_scene(size);
    BoxMedium haze = slab(3, 9);
    haze.sigma_s = glm::vec3(0.1f);
    haze.sigma_a = glm::vec3(0.02f);
    scene.media = {lump(3, 0.4), haze};
    scene.lights = {SunLight{{0.5, 0.3, 0.8}, glm::vec3(4)}};
    scene.world.radiance = glm::vec3(0.2f);
    scene.surfaces = {BoxSurface{{-20, -10, -20}, {20, -9.5, 20}, glm::vec3(0.5f)}};
    return scene;
}

/// Two crossing panes about the smoke, `x` metres to the side.
std::vector<Transparent> crossing_panes(double x, const TransparentLook& look)
{
    QuadTransparent one, other;
    one.corner = {x - 1.5, -6, -1.2};
    one.edges = {glm::dvec3(3, 2, 0), glm::dvec3(0, 0, 2.4)};
    other.corner = {x - 1.5, -4, -1.2};
    other.edges = {glm::dvec3(3, -2, 0), glm::dvec3(0, 0, 2.4)};
    one.look = other.look = look;
    return {one, other};
}

TransparentLook blended(Blend::Kind kind, glm::vec3 radiance, float alpha)
{
    TransparentLook look;
    look.blend.kind = kind;
    look.radiance = radiance;
    look.alpha = alpha;
    return look;
}

/// What panes that nobody sees make of a picture.
StabilityFigure unseen_panes(const StabilityBench& bench)
{
    Scene scene = pane_scene();
    const Picture without = layer(bench.render(scene, bench.settings, 0), &Still::composite);
    scene.transparents = crossing_panes(0, blended(Blend::Kind::add, glm::vec3(0), 1));
    return worst_difference(layer(bench.render(scene, bench.settings, 0), &Still::composite),
                            without);
}

/// What panes that glow make of one, against the right way.
StabilityFigure glowing_panes(const StabilityBench& bench)
{
    Scene scene = pane_scene();
    scene.transparents = crossing_panes(0, blended(Blend::Kind::alpha, {0.1f, 0.3f, 0.5f}, 0.5f));
    return rms_over_mean(
        layer(bench.render(scene, bench.settings, 0), &Still::composite),
        layer(bench.render(scene, bench.with(kTransparency, "split"), 0), &Still::composite));
}

/// Mean error along the edges of panes of what they change, over what they change, in a layer that
/// is smaller than the picture: against one as large, whose pixels know each pane's depth as well.
/// The smaller layer has as many rays at each of its sizes: what they miss of the smoke between
/// them is missed away from edges as well, by more than along them, and is no halo.
StabilityFigure pane_halo(const StabilityBench& bench, std::string_view resolution)
{
    constexpr int kRays = 24;
    const Scene without = pane_scene(kRays * (resolution == "half" ? 2 : 4));
    Scene with = without;
    with.transparents = crossing_panes(0.1, blended(Blend::Kind::alpha, {0.1f, 0.3f, 0.5f}, 0.5f));
    for (Transparent& one : with.transparents)  // so that edges of theirs are in the smoke
        std::get<QuadTransparent>(one).edges[1].z = 1.5;
    const auto changed = [&](std::string_view layer_size) {
        Settings settings = bench.with("resolution", layer_size);
        settings.format = Settings::Format::rgba32f;
        settings.jitter = Settings::Jitter::none;  // its noise is everywhere, and no halo
        Picture picture = layer(bench.render(with, settings, 0), &Still::composite);
        const Picture plain = layer(bench.render(without, settings, 0), &Still::composite);
        for (std::size_t i = 0; i < picture.rgb.size(); ++i)
            picture.rgb[i] -= plain.rgb[i];
        return picture;
    };
    const Picture actual = changed(resolution), expected = changed("full");
    double error = 0, change = 0;
    for (int y = 1; y + 1 < expected.height; ++y)
        for (int x = 1; x + 1 < expected.width; ++x) {
            const auto is_clear = [&](int dx, int dy) {
                return expected.at(x + dx, y + dy) == glm::vec3(0);
            };
            const bool near = is_clear(0, 0) != is_clear(1, 0) ||
                              is_clear(0, 0) != is_clear(-1, 0) ||
                              is_clear(0, 0) != is_clear(0, 1) || is_clear(0, 0) != is_clear(0, -1);
            if (!near)
                continue;
            for (int c = 0; c < 3; ++c) {
                error += std::abs(static_cast<double>(actual.at(x, y)[c] - expected.at(x, y)[c]));
                change += std::abs(static_cast<double>(expected.at(x, y)[c]));
            }
        }
    StabilityFigure figure = worst_difference(actual, expected);  // for its pictures
    figure.value = error / change;
    return figure;
}

/// Panes that have moved across the picture, as the camera did too, leave it as it is without them:
/// the frame after they are gone against one that never had any, in two views of as many frames.
StabilityFigure trail(const StabilityBench& bench)
{
    constexpr int kFrames = 16;
    Settings settings = bench.settings;
    settings.temporal = true;
    const auto last = [&](bool panes) {
        Scene scene = pane_scene();
        StabilityView view(bench, settings);
        Picture picture;
        for (int i = 0; i <= kFrames; ++i) {
            scene.transparents.clear();
            if (panes && i < kFrames)
                scene.transparents = crossing_panes(
                    0.2 * i - 1.6, blended(Blend::Kind::alpha, {0.1f, 0.3f, 0.5f}, 0.5f));
            scene.camera.position.x = 0.03 * (i - kFrames);
            scene.camera.look_at.x = scene.camera.position.x;
            view.set_scene(scene);
            picture = view.draw(scene);
        }
        return picture;
    };
    return worst_difference(last(true), last(false));
}

/// How far smoke that has moved behind and between standing panes is from the same at rest, over
/// what it is without panes.
StabilityFigure trail_behind(const StabilityBench& bench)
{
    constexpr int kFrames = 8;
    Settings settings = bench.settings;
    settings.temporal = true;
    StabilityFigure figure;
    std::array<double, 2> lag{};
    for (const bool panes : {false, true}) {
        Scene scene = pane_scene();
        if (panes)
            scene.transparents =
                crossing_panes(0, blended(Blend::Kind::alpha, {0.1f, 0.3f, 0.5f}, 0.25f));
        const auto last = [&](double step) {  // of as many frames, with the same jitter
            StabilityView view(bench, settings);
            Picture picture;
            for (int i = 0; i <= kFrames; ++i) {
                std::get<GridMedium>(scene.media[0]).translate.x = step * (i - kFrames);
                view.set_scene(scene);
                picture = view.draw(scene);
            }
            return picture;
        };
        figure = rms_over_mean(last(0.05), last(0));
        lag.at(panes ? 1 : 0) = figure.value;
    }
    figure.value = lag[1] / lag[0];
    return figure;
}

}  // namespace

void add_transparent_cases(std::vector<StabilityCase>& table)
{
    table.push_back({.group = 4,
                     .name = "unseen-panes",
                     .shows = "largest change of the picture by panes that nobody sees",
                     .bound = 1e-6,
                     .unit = "W/m^2/sr",
                     .reason = "what adds nothing and hides nothing is not there",
                     .asks = kTransparency,
                     .measure = unseen_panes});
    // The ways that are known to be wrong, against the right one.
    table.push_back(
        {.group = 4,
         .name = "glowing-panes",
         .shows = "rms change of panes that glow in smoke by blending their light in another way",
         .bound = 0.01,
         .unit = "of the mean",
         .reason = "a hundredth of the picture is not seen",
         .asks = kTransparency,
         .runs = [](const StabilitySubject& subject) { return !subject.asked.empty(); },
         .measure = glowing_panes});
    for (const std::string_view resolution : {"half", "quarter"})
        table.push_back(
            {.group = 4,
             .name = fmt::format("pane-halo-{}", resolution),
             .shows = fmt::format("halo of panes in smoke at {} size: mean error along their edges "
                                  "over what they change there",
                                  resolution),
             .bound = kJustNoticed,
             .unit = "of the edge",
             .reason = "1 % of the edge's contrast, as of surfaces' edges",
             .runs = marches,
             .measure = [resolution](const StabilityBench& bench) {
                 return pane_halo(bench, resolution);
             }});
    table.push_back({.group = 7,
                     .name = "trail-of-panes",
                     .shows = "largest change of the picture by panes that have moved through it, "
                              "the camera too",
                     .bound = 1e-6,
                     .unit = "W/m^2/sr",
                     .reason = "panes are no part of what is kept of the media",
                     .measure = trail});
    table.push_back({.group = 7,
                     .name = "trail-behind-panes",
                     .shows = "how far smoke that moves behind and between standing panes is from "
                              "what it is at rest, over the same without panes",
                     .bound = 1,
                     .unit = "times",
                     .reason = "panes that cover smoke leave it no trail of theirs",
                     .measure = trail_behind});
}

}  // namespace fumarole::study
