#pragma once

#include <array>
#include <optional>
#include <vector>

#include "prepared_frame.h"
#include "transparent/transparent_set.h"

namespace fumarole::transparent {

/// A flat transparent in a frame: a parallelogram, metres from the eye.
struct Placed {
    SeenTransparent seen;
    glm::dvec3 corner{0};
    std::array<glm::dvec3, 2> edges{};
    glm::dvec3 normal{0};  ///< away from the eye, unit length
    double distance = 0;   ///< distance of its plane from the eye [m]
    double slack = 0;      ///< below which a distance from its plane is none [m]
};

/// Where a frame's flat transparents lie, but for those that have their edge turned to the eye.
std::vector<Placed> place(const SeenTransparents& seen, const Eye& eye);

/// Puts them in the order in which they lie, the nearest first.
/// @param placed come by their nearest view_z
/// @returns nothing where two may cross, or it takes long to tell
std::optional<std::vector<Placed>> put_in_order(const std::vector<Placed>& placed);

}  // namespace fumarole::transparent
