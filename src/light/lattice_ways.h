#pragma once

#include <glm/glm.hpp>
#include <vector>

// Directions in which the nodes of a lattice of cubes see each other.

namespace fumarole::light {

/// The 26 to a node's neighbours, and 48 more whose steps go two nodes far along one axis.
constexpr int kNearWays = 26, kAllWays = 74;

struct LatticeWay {
    glm::ivec3 step{0};      ///< nodes along each axis, from one that it meets to the next
    double solid_angle = 0;  ///< solid angle that it stands for [sr]
};

/// Either of the two sets, each with weights that sum polynomials over the sphere exactly: 26 to
/// degree 7 (Lebedev 1976, "Quadratures on a sphere"), 74 to degree 11 by the same equations. The
/// latter begin with the former, and each way's opposite is the next one, or the one before.
std::vector<LatticeWay> lattice_ways(int count);

}  // namespace fumarole::light
