// A box of nodes in eye-centred world [m]: where a ray is in it, and where a point is in its texture.
#include "lib/ray_box.glsl"
#include "shared/light_volume_params.h"

// Where p + t d, t in [0, end], is inside. Empty: x >= y.
vec2 lattice_segment(LatticeParams lattice, vec3 p, vec3 d, float end)
{
    vec3 q = (lattice.node_from_world * vec4(p, 1.0)).xyz;
    vec3 dq = (lattice.node_from_world * vec4(d, 0.0)).xyz;
    vec2 t = ray_box(q, dq, vec3(0.0), lattice.last.xyz);
    return vec2(max(t.x, 0.0), min(t.y, end));
}

// Texture coordinates of q, in nodes, in one of the layers that are stacked along z; a point outside is moved
// to the faces, so no other layer is ever touched.
vec3 node_uvw(LatticeParams lattice, vec3 q, int layer)
{
    q = clamp(q, vec3(0.0), lattice.last.xyz);
    q.z += float(layer) * (lattice.last.z + 1.0);
    return (q + 0.5) * lattice.inverse_size.xyz;
}

vec3 lattice_uvw(LatticeParams lattice, vec3 p, int layer)
{
    return node_uvw(lattice, (lattice.node_from_world * vec4(p, 1.0)).xyz, layer);
}

vec3 node_position(LatticeParams lattice, ivec3 node)
{
    return (lattice.world_from_node * vec4(vec3(node), 1.0)).xyz;
}
