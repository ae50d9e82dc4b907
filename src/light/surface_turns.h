#pragma once

#include <string>

#include <fumarole/scene.h>
#include <fumarole/settings.h>

namespace fumarole::light {

/// How often surfaces send light on, and why so often.
struct SurfaceTurns {
    int turns = 0;
    std::string why;  ///< empty: there are no surfaces, or no lattice that could hold the light
};

/// By the surfaces, and by where media are: a camera that moves changes nothing.
SurfaceTurns surface_turns(const Scene& scene, const SceneSettings& settings);

}  // namespace fumarole::light
