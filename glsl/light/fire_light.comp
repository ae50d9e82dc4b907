// What arrives of a fire at places near surfaces, as if none stood in the way: radiance along rays through each part of
// the far sides of the box that glows.
//   in   which nodes are near to surfaces, and beyond the surfaces' lattice what is seen from there, and which lie outside
//        of surfaces; what the media are
//   out  layers: by how much the integral of radiance over the sphere is more than the length of the next; of radiance
//        times the way to where it comes from, an axis each [W/m^2]; alpha of the first two: as they came in
#include "lib/fire_nodes.glsl"
#include "lib/lattice.glsl"
#include "lib/slab.glsl"
#include "scene/light_volumes_block.glsl"

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(binding = 0) writeonly uniform image3D u_light_img;
layout(binding = FIELD_CROSSED_UNIT) uniform usampler3D u_near_tx;
layout(binding = FIELD_SIGMA_T_UNIT) uniform sampler3D u_flame_sigma_t_tx;
layout(binding = FIELD_EMISSION_UNIT) uniform sampler3D u_emission_tx;
layout(binding = FIELD_ALBEDO_UNIT) uniform sampler3D u_sigma_t_tx;

// Of the box, from p along wi to where that leaves it, `range` metres on.
vec3 arriving(vec3 p, vec3 wi, float range)
{
    const float kMostSteps = 32.0, kMostSmokeSteps = 8.0;
    const float kStep = 1.5;   // nodes
    const float kDark = 12.0;  // optical depth from which on nothing is seen
    LatticeParams flame = u_volumes.fire.flame, media = u_volumes.fire.media;
    float begin = clamp(lattice_segment(flame, p, wi, range).x, 0.0, range);
    vec3 tau = vec3(0.0);
    vec2 smoke = lattice_segment(media, p, wi, begin);
    if (smoke.x < smoke.y) {
        float steps = clamp(ceil((smoke.y - smoke.x) / (2.0 * kStep * media.spacing)), 1.0, kMostSmokeSteps);
        float ds = (smoke.y - smoke.x) / steps;
        for (float i = 0.5; i < steps; ++i)
            tau += ds * textureLod(u_sigma_t_tx, lattice_uvw(media, p + wi * (smoke.x + ds * i), 0), 0.0).rgb;
    }
    float steps = clamp(ceil((range - begin) / (kStep * flame.spacing)), 1.0, kMostSteps);
    float ds = (range - begin) / steps;
    vec3 first = lattice_uvw(flame, p + wi * begin, 0), last = lattice_uvw(flame, p + wi * range, 0);
    vec3 light = vec3(0.0);
    for (float i = 0.5; i < steps; ++i) {
        vec3 uvw = mix(first, last, i / steps);
        vec3 piece = ds * textureLod(u_flame_sigma_t_tx, uvw, 0.0).rgb;
        light += exp(-tau) * slab_weight(piece) * ds * textureLod(u_emission_tx, uvw, 0.0).rgb;
        tau += piece;
        if (min(tau.r, min(tau.g, tau.b)) > kDark)
            break;
    }
    return light;
}

// Of a rectangle from its corner under p to one that is `to` from there, so far away.
float corner_angle(vec2 to, float away) { return atan(to.x * to.y, away * sqrt(dot(to, to) + away * away)); }

void main()
{
    const float kFar = 2.0, kOfFar = 0.75;  // so many times its size off it is seen by so many of the rays
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
        float cell = longest / (away > kFar * longest ? ceil(kOfFar * fire.rays) : fire.rays);
        int faces = min(int(fire.rays), 6);  // never unrolled: compiling it six times takes longer than all of this
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
