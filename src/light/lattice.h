#pragma once

#include <glm/glm.hpp>

#include "gl/texture.h"
#include "shared/light_volume_params.h"
#include <fumarole/bounds.h>

// Boxes of nodes at which light, or what dims it, is worked out.

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

/// Nodes no closer than `spacing` units of the frame, and no more of them than `most` on an axis.
Lattice make_lattice(const glm::dmat4& unit_from_world, const Bounds& bounds, double spacing,
                     int most);

/// The same with cells of one edge where they were nearly so: it reaches out a little further.
Lattice make_cubes(const glm::dmat4& unit_from_world, const Bounds& bounds, double spacing,
                   int most);

/// The same box, or a little more, with `most` nodes along its longest edge.
Lattice coarser(const Lattice& fine, int most);

/// Metres, world.
Bounds bounds_of(const Lattice& lattice);
glm::dvec3 centre_of(const Lattice& lattice);

/// For an eye at `eye` (metres, world) and a texture of so many layers along z.
shared::LatticeParams to_shared(const Lattice& lattice, int layers, glm::dvec3 eye);

/// At least 2, and no more nodes than a texture of so many layers along z may have.
int clamp_to(int nodes, int layers, const gl::Device& gl);

/// A texel for each node, in layers along z.
gl::Texture make_volume(const gl::Device& gl, const char* label, const Lattice& lattice, int layers,
                        GLenum format);

/// Copies a layer of such a texture into one of another.
void copy_layer(const gl::Device& gl, const gl::Texture& from, int from_layer,
                const gl::Texture& to, int to_layer, glm::ivec3 nodes);

/// Where a lattice lies. What is filled at its nodes moves with it.
struct LatticePlace {
    glm::dvec3 origin{0};   ///< origin of the first node, metres, world
    glm::dmat3 edges{1.0};  ///< edges from node to node along each axis [m]
    glm::ivec3 count{0};    ///< nodes
};

LatticePlace place_of(const Lattice& lattice);

/// Metres from node to node, the least along any axis.
double spacing_of(const LatticePlace& place);

/// Within so many nodes two places are one: a thousandth of what a 32-bit shader tells apart.
constexpr double kSameNode = 1e-6;

/// Metres within which two places that are looked up in it are one.
inline double tolerance_of(const LatticePlace& place)
{
    return kSameNode * spacing_of(place);
}

/// Whether the one is the other, but for where it lies.
bool is_moved(const LatticePlace& then, const LatticePlace& now);

}  // namespace fumarole::light
