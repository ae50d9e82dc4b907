// From each node to the nearest surface, as light/crossed.frag keeps it: along the lattice's axes, down and up each, the
// diagonals between two of them, and those between all three.
#include "light/field.glsl"

const int kSteps = 26;

// Whether the node lies inside of a surface: of those around it most are seen from within. What its light tells of it is
// coarser, as lines go past a node at up to half the way to the next.
bool is_inside(ivec3 node)
{
    int within = 0;
    for (int way = 0; way < kSteps; ++way) {
        uint word = texelFetch(u_crossed_tx, node + way_of(way), 0).r;
        if (word >> 1 <= uint(WALL_STEPS))
            within += (word & 1u) == 1u ? 1 : -1;
    }
    return within > 0;
}

// In steps to the next node that way; 2: there is none before it.
float steps_to(ivec3 node, int way)
{
    uint steps = texelFetch(u_crossed_tx, node + way_of(way), 0).r >> 1;
    return steps > uint(WALL_STEPS) ? 2.0 : float(steps) / float(WALL_STEPS);
}
