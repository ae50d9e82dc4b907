// Parts of a box that glows, cells of some of its nodes, and what each lets out in each direction.
#include "lib/octahedral.glsl"
#include "shared/fire_cells.h"
#include "shared/light_volume_params.h"

struct FireCell {
    vec3 middle;  // of its light [m]
    uint number;  // of all cells
};

// Those that have any.
layout(std430, binding = FIRE_CELLS_BUFFER) buffer Cells
{
    uint u_cell_count;
    uint u_unused[3];
    FireCell u_cells[];
};

// From node to node along the edges of one: an even number.
int cell_edge(FireParams fire)
{
    vec3 last = fire.flame.last;
    return 2 * int(ceil(max(last.x, max(last.y, last.z)) / float(2 * FIRE_CELLS)));
}

ivec3 cell_counts(FireParams fire) { return (ivec3(fire.flame.last) - 1) / cell_edge(fire) + 1; }

// A cell's first node.
ivec3 first_of_cell(FireParams fire, uint number)
{
    ivec3 counts = cell_counts(fire);
    int i = int(number);
    return cell_edge(fire) * ivec3(i % counts.x, i / counts.x % counts.y, i / (counts.x * counts.y));
}

// Where its directions begin in the texture of all, an octahedral map each.
ivec2 tile_of(uint cell) { return FIRE_TILE * ivec2(cell % uint(FIRE_TILES), cell / uint(FIRE_TILES)); }
