#pragma once

#include <glm/glm.hpp>

#include "shared/light_volume_params.h"

namespace fumarole::light {

/// A box of nodes, the outermost on its faces.
struct Lattice {
    glm::dmat4 node_from_world{1.0};
    glm::ivec3 count{0};  ///< nodes along each axis, at least 2
};

/// A box of nodes as it is filled: its shader's view of it, for an eye amid it.
struct FieldLattice {
    shared::LatticeParams params{};
    glm::dvec3 eye{0};              ///< metres, world
    glm::dmat4 node_from_eye{1.0};  ///< nodes, from metres from the eye
    glm::ivec3 count{0};            ///< nodes along each axis
};

}  // namespace fumarole::light
