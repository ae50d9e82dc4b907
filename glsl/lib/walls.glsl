// Surfaces between the nodes of a lattice, along its axes: src/light/radiance_field.h.

// From a node to the nearest surface down and up each axis, in nodes; more than 1: none before the next node.
struct Walls {
    vec3 down, up;
};

Walls walls_of(sampler3D walls, ivec3 node, int nodes_z)
{
    return Walls(texelFetch(walls, node, 0).xyz, texelFetch(walls, node + ivec3(0, 0, nodes_z), 0).xyz);
}

// A place between nodes, moved away from those that lie behind a surface: where one crosses the line between two, the
// node on the place's own side stands for both.
//   first  texel of the walls of node 0
//   last   node along each axis
//   walls  of the node that is nearest to where the place is now
vec3 on_own_side(sampler3D walls_tx, ivec3 first, vec3 last, vec3 q, out Walls walls)
{
    vec3 base = clamp(floor(q), vec3(0.0), last - 1.0);
    vec3 from_low = clamp(q - base, 0.0, 1.0);
    vec3 t = from_low;
    vec3 is_high = step(0.5, from_low);
    // Twice, since which line is asked depends on the side along the other axes.
    for (int i = 0; i < 2; ++i) {
        walls = walls_of(walls_tx, first + ivec3(base + is_high), int(last.z) + 1);
        vec3 wall = mix(walls.up, walls.down, is_high);
        vec3 off = mix(from_low, 1.0 - from_low, is_high);
        vec3 side = mix(is_high, 1.0 - is_high, step(wall, off));
        t = mix(from_low, side, step(wall, vec3(1.0)));
        vec3 was_high = is_high;
        is_high = step(0.5, t);
        if (is_high == was_high)
            break;
    }
    return base + t;
}
