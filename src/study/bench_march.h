#pragma once

#include <fumarole/scene_renderer.h>

namespace fumarole::study {

/// The trilinear fetches from volumes that a march makes in one frame.
///
/// Counted are: one of each grid's density for every evaluation of the media; one of the optical
/// depth towards a light for every lit sample that the light reaches; one of the world's light for
/// every lit sample. Not counted: fetches from page tables (of one texel, not of eight), of
/// emission, of colour, and of the bands of the world's light where media differ in g. So the rate
/// that follows is, if not exact, too low.
struct MarchFetches {
    double density = 0, light = 0, world = 0;
    [[nodiscard]] double all() const { return density + light + world; }
};

/// Counts by rendering variants of the scene. All 0 where no grid is marched, or in froxels.
MarchFetches count_march_fetches(SceneRenderer& renderer, const Scene& scene,
                                 const Settings& settings);

}  // namespace fumarole::study
