#pragma once

#include <optional>
#include <vector>

#include "medium/glow_cells.h"
#include <fumarole/scene.h>

// Flames that are small beside the nodes that light is carried through: lights of their own.

namespace fumarole::light {

/// A light that stands for a part of a flame.
struct FlameLight {
    PointLight light;
    double radius = 0;  ///< metres: of the disc that it looks as large as
};

struct Flames {
    std::vector<FlameLight> lights;
    std::vector<bool> split_off;  ///< by medium, whether they are all of its glow
};

/// What flames are small beside.
struct FlameScale {
    double node = 0;       ///< metres from node to node of the lattice that is coarser; 0: none
    bool scatters = true;  ///< the media do, so that they are lit as close to a flame as can be
    /// Metres: those that may be lights. Of what scatters nothing only what stands beside it tells.
    [[nodiscard]] double longest() const;
};

/// One light for each that may be, or two or four of one that is longer than it is thick.
/// @param room lights that there may be
Flames lights_of_flames(const std::vector<std::optional<medium::SmallGlow>>& glows,
                        const FlameScale& scale, const std::vector<Surface>& surfaces,
                        std::size_t room);

}  // namespace fumarole::light
