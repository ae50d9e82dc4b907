// What arrives of a fire at places near surfaces, as if none stood in the way: from its cells, each a point; where the fire
// is too near for that, radiance along rays through each part of the far sides of its box.
//   in   which nodes are near to surfaces, and beyond the surfaces' lattice what is seen from there, and which lie outside
//        of surfaces; what the media are; the cells, and what they let out
//   out  layers: by how much the integral of radiance over the sphere is more than the length of the next; of radiance
//        times the way to where it comes from, an axis each [W/m^2]; alpha of the first two: as they came in
#include "lib/channels.glsl"
#include "lib/corner_angle.glsl"
#include "lib/fire_nodes.glsl"
#include "light/fire_cells.glsl"
#include "light/fire_smoke.glsl"

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(binding = 0) writeonly uniform image3D u_light_img;
layout(binding = FIELD_CROSSED_UNIT) uniform usampler3D u_near_tx;
layout(binding = FIELD_SOURCE_UNIT) uniform sampler2D u_out_tx;

// Of the smoke between a place and the box, towards a point in it: `mean`, and what it grows by from the middle to the
// box's faces along each axis.
struct Smoke {
    extinction_t mean;
    extinction_t along[3];
};

Smoke smoke_before(FireParams fire, vec3 p)
{
    Smoke smoke = Smoke(extinction_t(0.0), extinction_t[3](extinction_t(0.0), extinction_t(0.0), extinction_t(0.0)));
    int points = min(int(fire.rays), 8);  // never unrolled, which would take long to compile
    for (int i = 0; i < points; ++i) {
        vec3 side = vec3(ivec3(i & 1, i >> 1 & 1, i >> 2) * 2 - 1);
        vec3 way = fire.middle + 0.5 * side * fire.core - p;
        float range = length(way);
        vec3 wi = way / range;
        extinction_t depth = 0.125 * smoke_depth(p, wi, clamp(lattice_segment(fire.flame, p, wi, range).x, 0.0, range));
        smoke.mean += depth;
        for (int c = 0; c < 3; ++c)
            smoke.along[c] += 2.0 * side[c] * depth;
    }
    return smoke;
}

// Of the box, from p along wi to where that leaves it, `range` metres on.
vec3 arriving(vec3 p, vec3 wi, float range)
{
    const float kMostSteps = 32.0;
    const float kStep = 1.5;   // nodes
    const float kDark = 6e-6;  // nothing is seen through as little
    LatticeParams flame = u_volumes.fire.flame;
    float begin = clamp(lattice_segment(flame, p, wi, range).x, 0.0, range);
    vec3 through = exp(-in_color(smoke_depth(p, wi, begin)));
    float steps = clamp(ceil((range - begin) / (kStep * flame.spacing)), 1.0, kMostSteps);
    float ds = (range - begin) / steps;
    vec3 first = lattice_uvw(flame, p + wi * begin, 0), last = lattice_uvw(flame, p + wi * range, 0);
    vec3 light = vec3(0.0);
    for (float i = 0.5; i < steps; ++i) {
        vec3 uvw = mix(first, last, i / steps);
        vec3 piece = in_color(ds * flame_sigma_t(uvw)), after = through * exp(-piece);
        vec3 weight =
            mix((through - after) / max(piece, vec3(0.05)), through * (1.0 - 0.5 * piece), lessThan(piece, vec3(0.05)));
        light += weight * textureLod(u_emission_tx, uvw, 0.0).rgb;
        through = after;
        if (most(through) < kDark)
            break;
    }
    return light * ds;
}

void main()
{
    const float kNear = 1.0;  // cells off it is too near for them
    FireParams fire = u_volumes.fire;
    ivec3 node = ivec3(gl_GlobalInvocationID);
    ivec3 count = ivec3(fire.last) + 1;
    if (any(greaterThanEqual(node, count)))
        return;
    vec3 light[4] = vec3[4](vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0));
    uint at_node = texelFetch(u_near_tx, node, 0).r;
    if (at_node != 0u) {
        vec3 p = fire_place(fire, vec3(node));
        float longest = 2.0 * max(fire.core.x, max(fire.core.y, fire.core.z));
        float away = length(p - clamp(p, fire.middle - fire.core, fire.middle + fire.core));
        bool is_near = away < kNear * float(cell_edge(fire)) * fire.flame.spacing;
        Smoke smoke = smoke_before(fire, p);
        uint cells = is_near ? 0u : u_cell_count;
        for (uint i = 0u; i < cells; ++i) {
            vec3 way = u_cells[i].middle - p;
            float per_area = 1.0 / dot(way, way);
            vec3 wi = way * sqrt(per_area);
            const float kWays = float(FIRE_TILE - 2);
            vec2 uv = (vec2(tile_of(i)) + 1.0 + kWays * octahedral_uv(-wi)) / vec2(textureSize(u_out_tx, 0));
            vec3 at = (u_cells[i].middle - fire.middle) / fire.core;
            extinction_t depth = smoke.mean + smoke.along[0] * at.x + smoke.along[1] * at.y + smoke.along[2] * at.z;
            vec3 arrives = textureLod(u_out_tx, uv, 0.0).rgb * exp(-in_color(max(depth, extinction_t(0.0)))) * per_area;
            light[0] += arrives;
            for (int c = 0; c < 3; ++c)
                light[c + 1] += arrives * wi[c];
        }
        float cell = longest / fire.rays;
        int faces = is_near ? min(int(fire.rays), 6) : 0;  // never unrolled, which would take long to compile
        for (int face = 0; face < faces; ++face) {
            int axis = face >> 1, u = axis == 2 ? 0 : axis + 1, v = axis == 0 ? 2 : axis - 1;
            float side = (face & 1) != 0 ? 1.0 : -1.0;
            float height = side * (fire.middle[axis] + side * fire.core[axis] - p[axis]);
            if (height <= 0.0)
                continue;
            vec2 core = vec2(fire.core[u], fire.core[v]);
            vec2 parts = max(ceil(2.0 * core / cell - 1e-3), vec2(1.0));
            vec2 edges = 2.0 * core / parts;
            vec2 low = vec2(fire.middle[u] - p[u], fire.middle[v] - p[v]) - core;
            for (float j = 0.0; j < parts.y; ++j)
                for (float i = 0.0; i < parts.x; ++i) {
                    vec2 begin = low + vec2(i, j) * edges, end = begin + edges, at = 0.5 * (begin + end);
                    float angle = corner_angle(end, height) - corner_angle(vec2(begin.x, end.y), height) -
                                  corner_angle(vec2(end.x, begin.y), height) + corner_angle(begin, height);
                    vec3 way;
                    way[axis] = side * height;
                    way[u] = at.x;
                    way[v] = at.y;
                    float range = length(way);
                    vec3 wi = way / range;
                    vec3 arrives = arriving(p, wi, range) * max(angle, 0.0);
                    light[0] += arrives;
                    for (int c = 0; c < 3; ++c)
                        light[c + 1] += arrives * wi[c];
                }
        }
    }
    light[0] = max(light[0] - sqrt(light[1] * light[1] + light[2] * light[2] + light[3] * light[3]), vec3(0.0));
    for (int i = 0; i < 4; ++i) {
        float known = i > 1 ? 0.0 : float(at_node >> (8 + 8 * i) & 255u) / 255.0;
        imageStore(u_light_img, node + ivec3(0, 0, i * count.z), vec4(light[i], known));
    }
}
