// Lists the cells of the box that glows which do, in their order: one work group counts them.
//   in   emission
//   out  the list
#include "lib/lattice.glsl"
#include "light/fire_cells.glsl"
#include "scene/light_volumes_block.glsl"

layout(local_size_x = FIRE_CELL_GROUP) in;
layout(binding = FIELD_EMISSION_UNIT) uniform sampler3D u_emission_tx;

shared uint s_counts[FIRE_CELL_GROUP];

// xyz: the middle of its light, in nodes, times w: how much that is
vec4 light_of(FireParams fire, ivec3 first)
{
    ivec3 size = min(ivec3(cell_edge(fire)), ivec3(fire.flame.last) - first);
    vec4 sum = vec4(0.0);
    int parts = size.x * size.y * size.z;
    for (int i = 0; i < parts; ++i) {
        vec3 at = vec3(first + ivec3(i % size.x, i / size.x % size.y, i / (size.x * size.y))) + 0.5;
        float light = dot(textureLod(u_emission_tx, (at + 0.5) * fire.flame.inverse_size, 0.0).rgb, vec3(1.0));
        sum += light * vec4(at, 1.0);
    }
    return sum;
}

void main()
{
    FireParams fire = u_volumes.fire;
    ivec3 counts = cell_counts(fire);
    int cells = counts.x * counts.y * counts.z;
    int own = int(gl_LocalInvocationIndex);
    int each = (cells + FIRE_CELL_GROUP - 1) / FIRE_CELL_GROUP;
    int begin = min(own * each, cells), end = min(begin + each, cells);
    uint before = 0u;
    // First to count, then to list them: light is looked up again, as it would take room to keep.
    for (int turn = 0; turn < 2; ++turn) {
        uint count = 0u;
        for (int cell = begin; cell < end; ++cell) {
            vec4 light = light_of(fire, first_of_cell(fire, uint(cell)));
            if (!(light.w > 0.0))
                continue;
            if (turn == 1) {
                vec3 middle = (fire.flame.world_from_node * vec4(light.xyz / light.w, 1.0)).xyz;
                u_cells[before + count] = FireCell(middle, uint(cell));
            }
            ++count;
        }
        if (turn == 1)
            break;
        s_counts[own] = count;
        barrier();
        for (int i = 0; i < own; ++i)
            before += s_counts[i];
        if (own == FIRE_CELL_GROUP - 1)
            u_cell_count = before + count;
    }
}
