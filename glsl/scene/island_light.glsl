// The world's light, and what is scattered again, in media whose parts lie far apart: each part has nodes of its own,
// and what lies between them has those of all together. They stand one behind the other in one texture.
#include "shared/island_light_params.h"

layout(std140, binding = ISLAND_LIGHT_BLOCK) uniform IslandLight { IslandLightParams u_islands; };

// Scattered towards the eye at p, per metre and unit of sigma_s.
vec3 island_in_scattering(vec3 p, float g)
{
    const float kSlack = 0.5;  // nodes beyond which p is another's
    IslandLattice lattice;
    vec3 node;
    int i = 0;
    do {
        lattice = u_islands.lattices[i];
        node = (lattice.node_from_world * vec4(p, 1.0)).xyz;
        ++i;
    } while (i < u_islands.count &&
             (any(lessThan(node, vec3(-kSlack))) || any(greaterThan(node, lattice.last + kSlack))));
    if (lattice.first < 0.0)
        return vec3(0.0);
    node = clamp(node, vec3(0.0), lattice.last) + 0.5;
    node.z += lattice.first;
    return light_towards_eye(u_world_volume_tx, node * u_islands.inverse_size,
                             (lattice.last.z + 1.0) * u_islands.inverse_size.z, g);
}
