// What the media scatter at each node into each way: the phase function's bands against the light's, Henyey-Greenstein's
// l-th times g^l. Light is that which comes first, and what the order before brought along all ways.
// Orders that were not carried are taken to fall off as the last two did: a geometric series. Hillaire 2020, "A
// Scalable and Production Ready Sky and Atmosphere Rendering Technique", sec. 5.5.
//   in   coefficients of the light that comes first; radiance of each way; albedo and g
//        kTail: what was scattered the time before, and mean radiance of each order
//   out  radiance that a thick medium of this light would have, of each way [W/m^2/sr]; the light's mean radiance
#include "light/field_pairs.glsl"

// Variant
const bool kFirst = false;  // no way has brought anything yet
const bool kMean = false;   // the mean is all that is asked for
const bool kTail = false;   // orders are left out

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(r32ui, binding = 0) writeonly uniform uimage3D u_source_img;
layout(r32ui, binding = 1) writeonly uniform uimage3D u_mean_img;
layout(binding = FIELD_LIGHT_UNIT) uniform sampler3D u_first_tx;
layout(binding = FIELD_ALBEDO_UNIT) uniform sampler3D u_albedo_tx;
layout(binding = FIELD_SOURCE_UNIT) uniform usampler3D u_source_tx;
layout(binding = FIELD_SUMS_UNIT) uniform sampler3D u_sums_tx;

vec3 mean_of_order(int order) { return texelFetch(u_sums_tx, ivec3(order, 0, 0), 0).rgb; }

vec3 tail_of_last_order()
{
    const float kMostRatio = 0.98;
    vec3 last = mean_of_order(u_field.order);
    vec3 before = mean_of_order(u_field.order - 1);
    vec3 ratio = clamp(last / max(before, vec3(1e-30)), 0.0, kMostRatio);
    return ratio / (1.0 - ratio);
}

void gather_pair(ivec3 node, int k) { add_pair(g_light, k, light_of_way(node, k), light_of_way(node, k + 1)); }

void store(ivec3 at, vec3 source, vec3 tail)
{
    if (kTail)
        source += tail * (source - unpack_light(texelFetch(u_source_tx, at, 0).r));
    imageStore(u_source_img, at, pack_light(source, at));
}

void scatter_pair(ivec3 node, int k, vec3 tail)
{
    vec3 even, odd;
    sum_pair(k, even, odd);
    store(node + way_of(k), even + odd, tail);
    store(node + way_of(k + 1), even - odd, tail);
}

#define GATHER(k) gather_pair(node, k);
#define SCATTER(k) scatter_pair(node, k, tail);

void main()
{
    ivec3 node = own_node();
    if (any(greaterThanEqual(node, node_count())))
        return;
    for (int i = 0; i < kCount; ++i)
        g_light[i] = texelFetch(u_first_tx, node + layer_of(i), 0).rgb;
    if (!kFirst) {
        FOR_PAIRS_OF_26(GATHER, 0)
    }
    if (!kTail)
        imageStore(u_mean_img, node, pack_light(g_light[0] * spherical_harmonic(0, vec3(0.0)), node));
    if (kMean)
        return;
    vec4 albedo = texelFetch(u_albedo_tx, node, 0);
    vec3 scattered = albedo.rgb;
    int i = 0;
    for (int l = 0; l < kBands; ++l) {
        for (; i < kHarmonics[l]; ++i)
            g_light[i] *= scattered;
        scattered *= albedo.a;
    }
    vec3 tail = kTail ? tail_of_last_order() : vec3(0.0);
    FOR_PAIRS_OF_26(SCATTER, 0)
}
