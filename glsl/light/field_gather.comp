// Sums what a batch of ways brings to each node, as harmonics.
//   in   radiance of each way
//   out  coefficients of this light, kDimmed: and of what media let through of it; alpha of the first: the part of the
//        sphere whose ways do not end inside of a surface, or, of listed nodes that are not added to, 1
#include "light/field_pairs.glsl"
#include "light/field_taken.glsl"

// Variant
const int kWays = 0;         // of the batch, where its size is one of the usual two
const bool kAdds = false;    // to what was there
const bool kClear = false;   // of the world's light what surfaces let through
const bool kDimmed = false;  // and beside that what media let through as well
const bool kWorld = false;   // it is the world's or the surfaces': each way knows whether it ends inside of one
const bool kTaken = false;   // it is means along the near ways, each of which counts by what it meets
const bool kShares = false;  // light/sky_share.comp tells what they let through

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(rgba32f, binding = 0) uniform image3D u_light_img;
layout(rgba32f, binding = 1) uniform image3D u_dimmed_img;
layout(binding = FIELD_EMISSION_UNIT) uniform usampler3D u_shares_tx;  // nothing is emitted here

float g_outside = 0.0;
vec3 g_dimmed[kCount];

vec3 brought(ivec3 node, vec4 way, int k)
{
    if (!kClear)
        return way.rgb;
    float open = way.a == kInside ? 0.0 : way.a;
    if (kShares && way.a != kInside)
        open = share_of_sky(u_shares_tx, node, g_first + k, open);
    return u_field.ways[k].entry * open;
}

vec3 g_more = vec3(0.0);  // of the mean radiance, as some ways count more than others

void gather_pair(ivec3 node, int k)
{
    if (!kWorld) {
        vec3 one = light_of_way(node, k), other = light_of_way(node, k + 1);
        add_pair(g_light, k, one, other);
        if (kTaken)
            g_more += taken_more(node, k) * (one + other);
        return;
    }
    vec4 one = radiance_of_way(node, k), other = radiance_of_way(node, k + 1);
    float outside = float(one.a != kInside) + float(other.a != kInside);
    g_outside += outside * u_field.ways[k].solid_angle / (4.0 * 3.14159265);
    add_pair(g_light, k, brought(node, one, k), brought(node, other, k + 1));
    if (kDimmed)
        add_pair(g_dimmed, k, one.rgb, other.rgb);
}

#define GATHER(k)                                \
    if (k < (kWays > 0 ? kWays : u_field.count)) \
        gather_pair(node, k);

void main()
{
    ivec3 node = own_node();
    if (any(greaterThanEqual(node, node_count())))
        return;
    for (int i = 0; i < kCount; ++i)
        g_light[i] = g_dimmed[i] = vec3(0.0);
    FOR_PAIRS_OF_26(GATHER, 0)
    FOR_PAIRS_OF_48(GATHER, 26)
    g_light[0] += g_more / kMean0;
    for (int i = 0; i < kCount; ++i) {
        ivec3 at = node + layer_of(i);
        vec4 light = kAdds ? imageLoad(u_light_img, at) : vec4(0.0);
        float outside = i > 0 ? 0.0 : kListed && !kAdds && !kWorld ? 1.0 : light.a + g_outside;
        imageStore(u_light_img, at, vec4(light.rgb + g_light[i], outside));
        if (!kDimmed)
            continue;
        vec3 dimmed = kAdds ? imageLoad(u_dimmed_img, at).rgb : vec3(0.0);
        imageStore(u_dimmed_img, at, vec4(dimmed + g_dimmed[i], outside));
    }
}
