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
    std::vector<glm::dvec3> corners;    ///< its box's, or of a flat one or a piece of it, around it
    std::vector<glm::dvec2> outline;    ///< of a flat one, around it: pixels, where it is seen
    double slack = 0;                   ///< below which a distance from a plane is none [m]
    std::vector<Plane> planes;          ///< its own, or its box's faces'
    std::vector<Plane> cut_by;  ///< of a piece: what seen.cuts are, where its plane meets them
};

/// Where a frame's transparents lie, but for flat ones that have their edge turned to the eye.
std::vector<Placed> place(const TransparentSet& transparents, const SeenTransparents& seen,
                          const PreparedFrame& frame);

/// Puts them in the order in which they lie, the nearest first. Flat ones that cross, or lie before
/// each other in a ring, are cut into pieces (Newell, Newell and Sancha 1972).
/// @param placed come by their nearest view_z
/// @returns nothing where a mesh does, there are too many pieces, or it takes long to tell
std::optional<std::vector<Placed>> put_in_order(std::vector<Placed> placed,
                                                const PreparedFrame& frame);

/// Whether one of them is a piece.
bool has_pieces(const std::vector<Placed>& ordered);

}  // namespace fumarole::transparent
