#pragma once

#include <array>
#include <optional>
#include <vector>

#include "prepared_frame.h"
#include "transparent/transparent_set.h"

namespace fumarole::transparent {

/// A plane in a frame.
struct Plane {
    glm::dvec3 normal{0};  ///< away from the eye, unit length
    double distance = 0;   ///< distance from the eye [m]
};

/// A transparent in a frame: a parallelogram, or in a box; metres from the eye.
struct Placed {
    SeenTransparent seen;
    bool is_flat = true;
    glm::dvec3 corner{0};
    std::array<glm::dvec3, 3> edges{};  ///< of a flat one the last has no length
    double slack = 0;                   ///< below which a distance from a plane is none [m]
    std::vector<Plane> planes;          ///< its own, or its box's faces'
};

/// Where a frame's transparents lie, but for flat ones that have their edge turned to the eye.
std::vector<Placed> place(const TransparentSet& transparents, const SeenTransparents& seen,
                          const Eye& eye);

/// Puts them in the order in which they lie, the nearest first.
/// @param placed come by their nearest view_z
/// @returns nothing where two may cross, or it takes long to tell
std::optional<std::vector<Placed>> put_in_order(const std::vector<Placed>& placed);

}  // namespace fumarole::transparent
