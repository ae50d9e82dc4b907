// Group 4 too: rooms in haze, and what gets through their walls and roofs.

#include "study/stability_bench.h"

namespace fumarole::study {

namespace {

BoxSurface wall(glm::dvec3 min, glm::dvec3 max)
{
    return {min, max, glm::vec3(0.5f)};
}

/// The eye in a room 12 x 8 x 4 m of walls of 0.2 m, thinner than light's nodes are apart.
Scene room_scene(bool roof)
{
    Scene scene = bare_scene(48);
    scene.camera.vfov_deg = 70;
    scene.world.radiance = glm::vec3(0.5f);
    scene.surfaces = {wall({-300, -300, -4}, {300, 300, -2}), wall({-4.2, -9.2, -2}, {-4, 3.2, 2}),
                      wall({4, -9.2, -2}, {4.2, 3.2, 2}), wall({-4, -9.2, -2}, {4, -9, 2}),
                      wall({-4, 3, -2}, {4, 3.2, 2})};
    if (roof)
        scene.surfaces.emplace_back(wall({-4.2, -9.2, 2}, {4.2, 3.2, 2.2}));
    BoxMedium haze;
    haze.min = {-7, -12, -2};
    haze.max = {7, 6, 4};
    haze.sigma_s = glm::vec3(0.05f);
    scene.media = {haze};
    return scene;
}

StabilityFigure closed_room(const StabilityBench& bench)
{
    const Picture open = layer(bench.render(room_scene(false)), &Still::composite);
    const Picture closed = layer(bench.render(room_scene(true)), &Still::composite);
    Picture dark = closed;
    dark.rgb.assign(dark.rgb.size(), 0.0f);
    StabilityFigure figure = worst_difference(closed, dark);
    figure.value = closed.mean() / open.mean();
    return figure;
}

/// Haze above a roof in the sun, seen from under it: nothing of it, at a slant.
StabilityFigure lit_above_a_ceiling(const StabilityBench& bench)
{
    Scene scene = bare_scene(48);
    scene.surfaces = {wall({-300, -300, 2}, {300, 300, 2.05})};
    scene.lights = {SunLight{{0, 0, 1}, glm::vec3(1)}};
    BoxMedium haze;
    haze.min = {-20, -40, -2};
    haze.max = {20, -1, 6};
    haze.sigma_s = glm::vec3(0.05f);
    scene.media = {haze};
    scene.camera.position.z = 4;
    scene.camera.look_at.z = 4;
    const double above = layer(bench.render(scene), &Still::scattering).mean();
    scene.camera.position.z = -0.5;
    scene.camera.look_at.z = -0.2;
    const Picture under = layer(bench.render(scene), &Still::scattering);
    Picture dark = under;
    dark.rgb.assign(dark.rgb.size(), 0.0f);
    StabilityFigure figure = worst_difference(under, dark);
    figure.value = under.mean() / above;
    return figure;
}

}  // namespace

void add_indoor_cases(std::vector<StabilityCase>& table)
{
    table.push_back({.group = 4,
                     .name = "closed-room",
                     .shows = "light of the world in a closed room in haze, of that in an open one",
                     .bound = kScreenStep,
                     .unit = "of the mean",
                     .reason = std::string(kScreenReason),
                     .measure = closed_room});
    table.push_back(
        {.group = 4,
         .name = "lit-above-a-ceiling",
         .shows = "light of the haze above a ceiling that is seen through it, of that haze",
         .bound = kScreenStep,
         .unit = "of the mean",
         .reason = std::string(kScreenReason),
         .measure = lit_above_a_ceiling});
}

}  // namespace fumarole::study
