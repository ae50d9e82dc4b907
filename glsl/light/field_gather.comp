// Sums what a batch of ways brings to each node, as harmonics.
//   in   radiance of each way
//   out  coefficients of this light; alpha of the first: the part of the sphere whose ways do not end inside of a
//        surface
#include "light/field_pairs.glsl"

// Variant
const int kWays = 0;        // of the batch, where its size is one of the usual two
const bool kAdds = false;   // to what was there
const bool kClear = false;  // of the world's light what surfaces let through
const bool kWorld = false;  // it is the world's: each way knows whether it ends inside of a surface

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(rgba32f, binding = 0) uniform image3D u_light_img;

float g_outside = 0.0;

vec3 brought(vec4 way, int k)
{
    bool inside = way.a == kInside;
    if (kWorld && !inside)
        g_outside += u_field.ways[k].solid_angle / (4.0 * 3.14159265);
    return kClear ? u_field.ways[k].entry * (inside ? 0.0 : way.a) : way.rgb;
}

void gather_pair(ivec3 node, int k)
{
    vec4 one = radiance_of_way(node, k), other = radiance_of_way(node, k + 1);
    add_pair(k, brought(one, k), brought(other, k + 1));
}

#define GATHER(k) if (k < (kWays > 0 ? kWays : u_field.count)) gather_pair(node, k);

void main()
{
    ivec3 node = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(node, node_count())))
        return;
    for (int i = 0; i < kCount; ++i)
        g_light[i] = vec3(0.0);
    FOR_PAIRS_OF_26(GATHER, 0)
    FOR_PAIRS_OF_48(GATHER, 26)
    for (int i = 0; i < kCount; ++i) {
        ivec3 at = node + layer_of(i);
        vec4 light = kAdds ? imageLoad(u_light_img, at) : vec4(0.0);
        imageStore(u_light_img, at, vec4(light.rgb + g_light[i], i == 0 ? light.a + g_outside : 0.0));
    }
}
