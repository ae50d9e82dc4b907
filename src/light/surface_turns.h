#pragma once

#include <string>
#include <vector>

#include <fumarole/scene.h>
#include <fumarole/settings.h>

namespace fumarole::light {

/// How often surfaces send light on, and why so often.
struct SurfaceTurns {
    int turns = 0;
    std::string why;  ///< empty: there are no surfaces, or no lattice that could hold the light
};

/// What the answer stays for, as SkySeenKey.
struct SurfaceTurnsKey {
    std::vector<Surface> surfaces;
    std::size_t media = 0;  ///< number of them
    bool no_probes = true, no_lattice = false;
    int asked = kAutomatic;
    bool operator==(const SurfaceTurnsKey&) const = default;
};

SurfaceTurnsKey surface_turns_key(const Scene& scene, const SceneSettings& settings);

/// By the surfaces, and by where media are: a camera that moves changes nothing.
SurfaceTurns surface_turns(const Scene& scene, const SceneSettings& settings);

/// How surfaces send light on so often in all, some of it once the media's own is there.
struct TurnPlan {
    int first = 0;                ///< number of turns without that
    int again = 0;                ///< number each time it is there
    std::vector<int> taken_back;  ///< each time, number of turns before that don't count
};

/// @param rounds that it is there anew, 0 to 2. The media are filled anew before the second, by all
///        of the turns.
TurnPlan plan_turns(int turns, int rounds);

/// The last of TurnPlan::first, whose differences are a series.
constexpr int kNotedTurns = 3;

}  // namespace fumarole::light
