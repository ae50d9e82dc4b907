// Surfaces between the nodes of a lattice, along its axes: src/light/radiance_field.h.

// From a node to the nearest surface down and up each axis, in nodes; more than 1: none before the next node.
struct Walls {
    vec3 down, up;
};

Walls walls_of(sampler3D walls, ivec3 node, int nodes_z)
{
    return Walls(texelFetch(walls, node, 0).xyz, texelFetch(walls, node + ivec3(0, 0, nodes_z), 0).xyz);
}
