// A box of nodes in eye-centred world [m]: where a ray is in it, and where a point is in its texture.
#include "lib/ray_box.glsl"
#include "shared/light_volume_params.h"

// In nodes: p, and a way.
vec3 node_at(LatticeParams lattice, vec3 p) { return (lattice.node_from_world * vec4(p, 1.0)).xyz; }
vec3 node_way(LatticeParams lattice, vec3 d) { return (lattice.node_from_world * vec4(d, 0.0)).xyz; }

// Where p + t d, t in [0, end], is inside. Empty: x >= y.
vec2 lattice_segment(LatticeParams lattice, vec3 p, vec3 d, float end)
{
    vec2 t = ray_box(node_at(lattice, p), node_way(lattice, d), vec3(0.0), lattice.last);
    return vec2(max(t.x, 0.0), min(t.y, end));
}

// Texture coordinates of p, and of a way, which add up along a line, in the first of the layers that are stacked
// along z.
vec3 first_layer_at(LatticeParams lattice, vec3 p) { return (node_at(lattice, p) + 0.5) * lattice.inverse_size; }

vec3 first_layer_way(LatticeParams lattice, vec3 d) { return node_way(lattice, d) * lattice.inverse_size; }

// The same in another layer. A point outside is moved to the faces, so no other layer is ever touched; at the
// texture's own faces its sampler does that.
vec3 in_layer(LatticeParams lattice, vec3 uvw, int layer)
{
    float node = lattice.inverse_size.z;
    float half_node = 0.5 * node;
    float nodes = lattice.last.z * node;
    uvw.z = clamp(uvw.z, half_node, half_node + nodes) + float(layer) * (nodes + node);
    return uvw;
}

vec3 lattice_uvw(LatticeParams lattice, vec3 p, int layer)
{
    return in_layer(lattice, first_layer_at(lattice, p), layer);
}

// Walks n^3 places of a cell, evenly, by counting: an integer's division is slow on most devices.
ivec3 next_in_cell(ivec3 place, int n)
{
    ++place.x;
    if (place.x == n)
        place = ivec3(0, place.y + 1, place.z);
    if (place.y == n)
        place = ivec3(0, 0, place.z + 1);
    return place;
}

// Of its middle, in cells.
vec3 place_in_cell(ivec3 place, int n) { return (vec3(place) + 0.5) / float(n) - 0.5; }

vec3 node_position(LatticeParams lattice, ivec3 node) { return (lattice.world_from_node * vec4(vec3(node), 1.0)).xyz; }
