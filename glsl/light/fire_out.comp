// What each cell of a box that glows lets out in each direction, through what dims it on its way out of the box.
//   in   what the media are; the cells
//   out  [W/sr], an octahedral map a cell
#include "light/fire_cells.glsl"
#include "light/fire_smoke.glsl"

layout(local_size_x = FIRE_TILE, local_size_y = FIRE_TILE) in;
layout(binding = 0) writeonly uniform image2D u_out_img;

const int kMostParts = 8;
shared vec4 s_light[kMostParts];   // [W/sr]
shared vec4 s_middle[kMostParts];  // in nodes

// Two nodes long along each edge, from one on.
void look_at_part(FireParams fire, ivec3 first, int part)
{
    ivec3 size = clamp(ivec3(fire.flame.last) - first, ivec3(0), ivec3(2));
    vec3 light = vec3(0.0);
    vec4 middle = vec4(0.0);
    for (int i = 0; i < 8; ++i) {
        ivec3 at = ivec3(i & 1, i >> 1 & 1, i >> 2);
        if (any(greaterThanEqual(at, size)))
            continue;
        vec3 node = vec3(first + at) + 0.5;
        vec3 here = textureLod(u_emission_tx, (node + 0.5) * fire.flame.inverse_size, 0.0).rgb;
        light += here;
        middle += dot(here, vec3(1.0)) * vec4(node, 1.0);
    }
    s_light[part] = vec4(light * abs(determinant(mat3(fire.flame.world_from_node))), 0.0);
    s_middle[part] = vec4(middle.xyz / max(middle.w, 1e-30), 0.0);
}

// From a node on to where the box ends.
extinction_t depth_from(FireParams fire, vec3 node, vec3 wi)
{
    const float kMostSteps = 48.0;
    const float kStep = 1.5;   // nodes
    const float kDark = 12.0;  // nothing is seen through as much
    vec3 p = (fire.flame.world_from_node * vec4(node, 1.0)).xyz;
    vec3 way = node_way(fire.flame, wi);
    float leaves = lattice_segment(fire.flame, p, wi, 1e9).y;
    float steps = clamp(ceil(leaves * length(way) / kStep), 1.0, kMostSteps);
    float ds = leaves / steps;
    vec3 first = (node + 0.5) * fire.flame.inverse_size, step = way * ds * fire.flame.inverse_size;
    extinction_t depth = extinction_t(0.0);
    for (float i = 0.5; i < steps; ++i) {
        depth += ds * flame_sigma_t(first + i * step);
        if (least_of(depth) > kDark)
            break;
    }
    return depth;
}

void main()
{
    FireParams fire = u_volumes.fire;
    uint cell = gl_WorkGroupID.x;
    bool glows = cell < u_cell_count;
    int half_edge = cell_edge(fire) / 2;
    int parts = glows ? half_edge * half_edge * half_edge : 0;
    int own = int(gl_LocalInvocationIndex);
    if (own < parts)
        look_at_part(fire,
                     first_of_cell(fire, u_cells[cell].number) +
                         2 * ivec3(own % half_edge, own / half_edge % half_edge, own / (half_edge * half_edge)),
                     own);
    barrier();
    ivec2 texel = ivec2(gl_LocalInvocationID.xy);
    const int kWays = FIRE_TILE - 2;
    vec3 wi = octahedral_direction((vec2(octahedral_wrap(texel - 1, kWays)) + 0.5) / float(kWays));
    float across = 2.0 / length(node_way(fire.flame, wi));  // metres
    vec3 sum = vec3(0.0);
    // Of eight parts every other direction has those of which none are neighbours, the next one the others.
    int looked_at = max(parts / 2, min(parts, 1));
    float share = float(parts) / float(max(looked_at, 1));
    for (int k = 0; k < looked_at; ++k) {
        int i = parts > 1 ? 2 * k + (bitCount(k) + texel.x + texel.y & 1) : 0;
        if (s_light[i].rgb == vec3(0.0))
            continue;
        vec3 node = s_middle[i].xyz;
        // Its own depth is spread over it, on both sides of the middle.
        vec3 own_depth = in_color(across * flame_sigma_t((node + 0.5) * fire.flame.inverse_size));
        vec3 depth = in_color(depth_from(fire, node, wi));
        sum += s_light[i].rgb * slab_weight(own_depth) * exp(min(0.5 * own_depth, 20.0) - depth);
    }
    if (glows)
        imageStore(u_out_img, tile_of(cell) + texel, vec4(share * sum, 0.0));
}
