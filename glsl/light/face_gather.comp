// What surfaces send to the nodes, and media, gathered along many ways that are others at each node: of the few that light
// is carried along from node to node, all of a wall would show the same stripes.
//   in   surfaces' walls, with the clearance, and what they send on; sigma_t; what is scattered into the near
//        ways; coefficients of what comes from beyond the lattice
//   out  coefficients of what surfaces send, kScatters: and beside it of this and what media send; alpha as it was
#include "light/lattice_ray.glsl"
#include "light/way_pairs.glsl"
#include "lib/phase.glsl"
#include "lib/slab.glsl"
#include "scene/light_volumes.glsl"
#include "shared/spherical_harmonics.h"

// Variant
const int kBands = 1;
const bool kClear = false;     // the media don't dim it
const bool kMarched = false;   // there are some without a closed form
const bool kBeyond = false;    // some light comes from beyond the lattice
const bool kScatters = false;  // light that the media scatter is asked for

const int kCount = kHarmonics[kBands - 1];

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(rgba32f, binding = 0) uniform image3D u_light_img;
layout(rgba32f, binding = 1) writeonly uniform image3D u_all_light_img;
layout(binding = FIELD_SOURCE_UNIT) uniform usampler3D u_source_tx;
layout(binding = FIELD_SIGMA_T_UNIT) uniform sampler3D u_sigma_t_tx;
layout(binding = FACE_LIGHT_UNIT) uniform sampler3D u_face_light_tx;
layout(binding = FIELD_LIGHT_UNIT) uniform sampler3D u_beyond_light_tx;

struct Arriving {
    vec3 of_surfaces, of_media;
};

// Of the near ways, which are the batch, the nearest one.
int near_way(vec3 wi)
{
    float most = 0.0;
    int way = 0;
#define LOOK_AT(k)                                                 \
    {                                                              \
        float along = dot(u_field.ways[k].wi, wi);                 \
        way = abs(along) > most ? (along > 0.0 ? k : k + 1) : way; \
        most = max(most, abs(along));                              \
    }
    FOR_PAIRS_OF_26(LOOK_AT, 0)
    return way;
}

// Through the media from a node on, along a way in nodes, to where it has gone t metres.
//   out  their optical depth, and the radiance that they add
vec3 through_media(vec3 from, vec3 course, vec3 wi, float t, float shift, out vec3 light)
{
    const int kSamples = 8;
    vec2 range = ray_box(from, course, u_field.media_low, u_field.media_high);
    range = vec2(max(range.x, 0.0), min(range.y, t));
    vec3 tau = vec3(0.0);
    light = vec3(0.0);
    float metres = (range.y - range.x) / float(kSamples);
    int k = kScatters ? near_way(wi) : 0;
    for (int i = 0; i < kSamples && metres > 0.0; ++i) {
        vec3 q = from + course * (range.x + metres * (float(i) + shift));
        ivec3 node = clamp(ivec3(q + 0.5), ivec3(0), node_count() - 1);
        vec3 piece = texelFetch(u_sigma_t_tx, node, 0).rgb * metres;
        if (kScatters && piece != vec3(0.0)) {
            vec3 sent = piece * unpack_light(texelFetch(u_source_tx, node + way_of(k), 0).rg);
            light += exp(-tau) * slab_weight(piece) * sent;
        }
        tau += piece;
    }
    return tau;
}

// Radiance that arrives at a node from wi, of unit length.
Arriving arriving(ivec3 from, vec3 wi, float shift)
{
    const float kWithoutEnd = 1e30;
    vec3 course = off_axes(node_way(u_field.nodes, wi));
    Met met = first_met(from, course, kWithoutEnd);
    Arriving sum = Arriving(vec3(0.0), vec3(0.0));
    if (met.layer >= 0)
        sum.of_surfaces = texelFetch(u_face_light_tx, met.node + layer_of(met.layer), 0).rgb;
    if (kClear || (!kScatters && sum.of_surfaces == vec3(0.0)))
        return sum;
    vec3 tau = vec3(0.0);
    if (kMarched || kScatters)
        tau = through_media(vec3(from), course, wi, met.t, shift, sum.of_media);
    if (!kScatters)
        tau += vec3(closed_depth(node_position(u_field.nodes, from), wi, met.t));
    sum.of_surfaces *= exp(-tau);
    return sum;
}

void main()
{
    const int kWays = 256;
    const int kWaysAfar = 64;  // from surfaces that look nodes up, which seldom reach them
    const int kAfar = 3;       // nodes
    const float kGoldenAngle = 2.3999632;
    ivec3 node = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(node, node_count())))
        return;
    vec3 light[kCount], all_light[kCount];
    for (int i = 0; i < kCount; ++i)
        light[i] = all_light[i] = kBeyond ? texelFetch(u_beyond_light_tx, node + layer_of(i), 0).rgb : vec3(0.0);
    float outside = imageLoad(u_light_img, node).a;
    bool is_afar = unpack_clearance(texelFetch(u_crossed_tx, node, 0).rg, bvec3(false)).nodes >= kAfar;
    int ways = outside == 0.0 ? 0 : is_afar ? kWaysAfar : kWays;
    float shift = fract(dot(vec3(node), vec3(0.8191725, 0.6710436, 0.5497005)));
    float turn = 2.0 * kPi * fract(dot(vec3(node), vec3(0.7548777, 0.5698403, 0.3819660)));
    for (int k = 0; k < ways; ++k) {
        // A Fibonacci lattice over the sphere, turned and shifted by sequences of which neighbours have what is far apart
        // (Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences").
        float z = 1.0 - 2.0 * (float(k) + shift) / float(ways);
        float phi = float(k) * kGoldenAngle + turn;
        vec3 wi = vec3(sqrt(max(1.0 - z * z, 0.0)) * vec2(cos(phi), sin(phi)), z);
        Arriving one = arriving(node, wi, fract(phi));
        vec3 of_both = one.of_surfaces + one.of_media;
        for (int i = 0; i < kCount; ++i) {
            float weight = 4.0 * kPi / float(ways) * spherical_harmonic(i, wi);
            light[i] += weight * one.of_surfaces;
            if (kScatters)
                all_light[i] += weight * of_both;
        }
    }
    for (int i = 0; i < kCount; ++i) {
        ivec3 at = node + layer_of(i);
        imageStore(u_light_img, at, vec4(light[i], i == 0 ? outside : 0.0));
        if (kScatters)
            imageStore(u_all_light_img, at, vec4(all_light[i], i == 0 ? outside : 0.0));
    }
}
