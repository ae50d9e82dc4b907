// Light on surfaces from all around: the world's, filtered by roughness, and what placed probes have seen.
#include "lib/phase.glsl"
#include "lib/probe_map.glsl"

// Variant
const bool kProbes = false;           // some are placed
const bool kProbeIrradiance = false;  // and light what is not glossy too

layout(std140, binding = PROBES_BLOCK) uniform Probes { ProbesParams u_probes; };
layout(binding = WORLD_PROBE_UNIT) uniform sampler2DArray u_world_probe_tx;
layout(binding = PROBES_UNIT) uniform sampler2DArray u_probes_tx;

// The world's radiance as a surface of GGX's alpha shows it about d, of any length.
vec3 world_reflection(vec3 d, float alpha)
{
    ProbeLevel level = probe_level(u_probes.world.last, alpha);
    vec2 uv = octahedral_uv(d);
    return mix(probe_map_at(u_world_probe_tx, u_probes.world.maps[level.lower], 0, uv).rgb,
               probe_map_at(u_world_probe_tx, u_probes.world.maps[level.lower + 1], 0, uv).rgb, level.part);
}

vec3 layer_reflection(int layer, ProbeLevel level, vec2 uv)
{
    return mix(probe_map_at(u_probes_tx, u_probes.placed.maps[level.lower], layer, uv).rgb,
               probe_map_at(u_probes_tx, u_probes.placed.maps[level.lower + 1], layer, uv).rgb, level.part);
}

// Of what probes there are at a place: each covers its weight of what those before it leave, and what they cover together
// is shared out by their weights over how far it is to each in its radii. Shares by the order of distance would jump
// where two that are as near change places.
struct ProbeShares {
    float left;  // for the world
    float sum;   // of the shares
};

float probe_share(int i, vec3 p, inout ProbeShares shares)
{
    const float kNearest = 1e-4;
    float d = distance(p, u_probes.probes[i].position);
    float weight = u_probes.probes[i].weight *
                   clamp((u_probes.probes[i].radius - d) / max(u_probes.probes[i].edge, 1e-6), 0.0, 1.0);
    d /= u_probes.probes[i].radius;
    float share = weight / max(d * d, kNearest);
    shares.left *= 1.0 - weight;
    shares.sum += share;
    return share;
}

// Where light lies that comes to p from d, seen from where a probe was captured, and how far it is from p [m]: 0 if it is
// taken to be far away.
vec4 from_probe(int i, vec3 seen_from, vec3 p, vec3 d)
{
    vec3 q = p - seen_from;
    float way = 0.0;
    if (u_probes.probes[i].parallax == kParallaxSphere) {
        float r = u_probes.probes[i].radius;
        float b = dot(q, d);
        way = sqrt(max(b * b + r * r - dot(q, q), 0.0)) - b;
    }
    if (u_probes.probes[i].parallax == kParallaxBox) {
        vec3 along = mix(vec3(-1e-6), vec3(1e-6), greaterThanEqual(d, vec3(0.0)));
        vec3 inverse = 1.0 / (abs(d.x) > 1e-6 && abs(d.y) > 1e-6 && abs(d.z) > 1e-6 ? d : d + along);
        vec3 ends = max((u_probes.probes[i].box_min - p) * inverse, (u_probes.probes[i].box_max - p) * inverse);
        way = max(min(ends.x, min(ends.y, ends.z)), 0.0);
    }
    vec3 place = q + d * way;
    return u_probes.probes[i].parallax == 0 ? vec4(d, 0.0) : vec4(place, way);
}

// Light from what lies so much farther: more of it is dimmed by the fog that the probe stands in, and scattered into the
// way, as much as all around sends where it is even.
vec3 through_fog(int i, int layer, vec3 light, float farther)
{
    const float kMost = 1.0;  // optical depth that may be taken off
    const float kMean = 0.2820948 / kPi;
    if (u_probes.probes[i].fog == 0.0)
        return light;
    vec3 source = u_probes.probes[i].fog_albedo * kMean *
                  texelFetch(u_probes_tx, ivec3(0, u_probes.placed.harmonics, layer), 0).rgb;
    return max(mix(source, light, exp(min(-u_probes.probes[i].fog * farther, kMost))), 0.0);
}

vec3 probe_reflection(int i, int layer, vec3 seen_from, float alpha, vec3 p, vec3 d)
{
    vec4 from = from_probe(i, seen_from, p, d);
    float way = length(from.xyz);
    // A lobe covers as much of what it meets from near, which is less as it is seen from afar (Lagarde and de Rousiers 2014).
    if (from.w > 0.0)
        alpha = min(alpha * from.w / max(way, 1e-6), 1.0);
    ProbeLevel level = probe_level(u_probes.placed.last, alpha);
    return through_fog(i, layer, layer_reflection(layer, level, octahedral_uv(from.xyz)),
                       from.w > 0.0 ? from.w - way : 0.0);
}

// Which probes have a share at p, a bit each.
uint probes_at(vec3 p)
{
    uint found = 0u;
    for (int i = 0; i < u_probes.count; ++i)
        if (u_probes.probes[i].weight > 0.0 && distance(p, u_probes.probes[i].position) < u_probes.probes[i].radius)
            found |= 1u << i;
    return found;
}

// What it has seen, and as far as that is not all there yet what it had seen before.
vec3 probe_light(int i, vec3 p, vec3 d, float alpha)
{
    vec3 light = vec3(0.0);
    float rest = 1.0;
    // llvmpipe works out both sides of a branch for all pixels, while a loop ends with the last pixel that goes on.
    for (bool old = false;; old = true) {
        float part = old ? rest : u_probes.probes[i].newness;
        light +=
            part * probe_reflection(i, old ? u_probes.probes[i].old_layer : u_probes.probes[i].layer,
                                    old ? u_probes.probes[i].old_seen_from : u_probes.probes[i].seen_from, alpha, p, d);
        rest -= part;
        if (old || rest <= 0.0)
            break;
    }
    return light;
}

// What a surface of alpha at p shows about d, of unit length; world: of the world. probes: probes_at(p)
vec3 probes_reflection(vec3 p, vec3 d, float alpha, vec3 world, uint probes)
{
    ProbeShares shares = ProbeShares(1.0, 0.0);
    vec3 sum = vec3(0.0);
    for (uint left = probes;;) {
        int i = max(findLSB(left), 0);
        float share = left == 0u ? 0.0 : probe_share(i, p, shares);
        sum += share * probe_light(i, p, d, alpha);
        left &= left - 1u;
        if (left == 0u)
            break;
    }
    return shares.sum > 0.0 ? mix(sum / shares.sum, world, shares.left) : world;
}

// [W/m^2] at p with a normal of unit length; world: of the world, as if nothing hid it.
vec3 probes_irradiance(vec3 p, vec3 n, vec3 world)
{
    ProbeShares shares = ProbeShares(1.0, 0.0);
    vec3 sum = vec3(0.0);
    for (int i = 0; i < u_probes.count; ++i) {
        float share = probe_share(i, p, shares);
        if (share == 0.0)
            continue;
        vec3 light = probe_irradiance(u_probes_tx, u_probes.placed.harmonics, u_probes.probes[i].layer, n).rgb;
        if (u_probes.probes[i].newness < 1.0)
            light = mix(probe_irradiance(u_probes_tx, u_probes.placed.harmonics, u_probes.probes[i].old_layer, n).rgb,
                        light, u_probes.probes[i].newness);
        sum += share * light;
    }
    return shares.sum > 0.0 ? mix(sum / shares.sum, world, shares.left) : world;
}
