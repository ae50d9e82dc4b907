#pragma once

#include <functional>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "medium/glow.h"
#include <fumarole/bounds.h>

namespace fumarole::medium {

/// What a medium glows, and dims of it itself, in cells along the world's axes.
struct GlowCells {
    Bounds bounds;                    ///< metres, world
    glm::ivec3 count{0};              ///< along x, y, z; 0: nothing dims
    std::vector<glm::dvec3> power;    ///< W/sr of each, x fastest, were nothing in the way
    std::vector<glm::dvec3> sigma_t;  ///< 1/m, its mean in each

    [[nodiscard]] bool empty() const { return power.empty(); }
    /// What gets out of all cells over what would if the same came from places in equal parts, the
    /// mean of 26 directions.
    /// @param places metres, world; where they lie beyond the cells, as on their nearest side
    [[nodiscard]] glm::dvec3 escapes(std::span<const glm::dvec3> places) const;
};

/// What glows in a place that is small beside the nodes that light is carried through.
struct SmallGlow {
    Glow glow;
    GlowCells cells;
};

/// @param radiance what a metre adds there [W/m^2/sr/m], sigma_t [1/m]: at a place of the world,
///        asked for from several threads
GlowCells glow_cells(const Bounds& bounds, const std::function<glm::dvec3(glm::dvec3)>& radiance,
                     const std::function<glm::dvec3(glm::dvec3)>& sigma_t);

}  // namespace fumarole::medium
