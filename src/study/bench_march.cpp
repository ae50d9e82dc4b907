#include "study/bench_march.h"

#include <algorithm>

namespace fumarole::study {

namespace {

/// Evaluations of the media in one frame.
double evaluations(SceneRenderer& renderer, const Scene& scene, const Settings& settings)
{
    StillReport report;
    renderer.render(scene, settings, {.picture = false, .progress = {}}, &report);
    return report.samples;
}

}  // namespace

MarchFetches count_march_fetches(SceneRenderer& renderer, const Scene& scene,
                                 const Settings& settings)
{
    MarchFetches fetches;
    const auto grids = static_cast<double>(
        std::count_if(scene.media.begin(), scene.media.end(),
                      [](const Medium& m) { return std::holds_alternative<GridMedium>(m); }));
    const bool others = std::any_of(scene.media.begin(), scene.media.end(), [](const Medium& m) {
        const auto* box = std::get_if<BoxMedium>(&m);
        return box != nullptr && std::holds_alternative<NoiseProfile>(box->profile);
    });
    if (settings.mode != Settings::Mode::raymarch || grids == 0 || others)
        return fetches;
    const double samples = evaluations(renderer, scene, settings);
    fetches.density = samples * grids;
    if (settings.shadow_volume_size == 0)
        return fetches;  // what a march to the lights fetches is among the samples

    // A shadow of one step, marched, is an evaluation for each marched medium where the cache would
    // be a fetch.
    Settings marched = settings;
    marched.shadow_volume_size = 0;
    marched.shadow_steps = 1;
    if (settings.volume_shadows && !scene.lights.empty())
        fetches.light = (evaluations(renderer, scene, marched) - samples) / grids;
    if (settings.ambient_volume_size == 0 || scene.world.radiance == glm::vec3(0))
        return fetches;
    // A light at the eye reaches whatever a ray from the eye reaches: one such step a lit sample.
    Scene from_eye = scene;
    from_eye.lights = {PointLight{.position = scene.camera.position}};
    fetches.world = (evaluations(renderer, from_eye, marched) - samples) / grids;
    return fetches;
}

}  // namespace fumarole::study
