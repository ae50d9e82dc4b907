#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "light/lattice.h"
#include "surface/surface_set.h"

namespace fumarole::light {

/// The nodes that places on surfaces look light up at (glsl/scene/world_irradiance.glsl), and some
/// more, as node_word() has them (shared/field_nodes.h). Empty: nearly all are, or none.
/// @param rim those around SURFACES_RIM too, for places beyond the lattice
std::vector<std::uint32_t>
nodes_near_surfaces(const FieldLattice& lattice,
                    std::span<const surface::SurfaceSet::Instance> surfaces, bool rim);

}  // namespace fumarole::light
