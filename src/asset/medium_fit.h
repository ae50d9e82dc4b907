#pragma once

#include <fumarole/scene.h>

namespace fumarole::asset {

/// Which grids of a medium are new to what they are taken for.
struct NewGrids {
    bool density = false, emission = false, temperature = false;
};

/// Chooses what the new grids of a medium are multiplied by from their values, as make_auto_scene
/// does: an average line of sight through the density is 75 % opaque, and a bright one through what
/// glows outshines sunlit smoke. The extinction's colour and the albedo stay, where there are any.
/// The grids are those that the medium holds.
/// @throws Error naming file and grid if it is 0 everywhere, or takes a coefficient that no scene
/// may have
void fit_medium(GridMedium& medium, NewGrids which);

}  // namespace fumarole::asset
