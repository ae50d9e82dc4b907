// Sums what a batch of ways brings to each node, as harmonics.
//   in   radiance of each way
//   out  coefficients of this light; alpha of the first: what surfaces let through of the world's, of the way that has
//        most
#include "light/field.glsl"
#include "shared/spherical_harmonics.h"

// Variant
const int kBands = 1;
const bool kAdds = false;   // to what was there
const bool kClear = false;  // of the world's light what surfaces let through

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(rgba32f, binding = 0) uniform image3D u_light_img;
layout(binding = FIELD_WAYS_UNIT) uniform usampler3D u_ways_tx;

void main()
{
    const int kCount = kHarmonics[kBands - 1];
    ivec3 node = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(node, node_count())))
        return;
    vec3 sum[kCount];
    for (int i = 0; i < kCount; ++i)
        sum[i] = vec3(0.0);
    float seen = 0.0;
    for (int k = 0; k < u_field.count; ++k) {
        vec4 way = unpack_way(texelFetch(u_ways_tx, node + way_of(k), 0).rg);
        vec3 light = u_field.ways[k].solid_angle * (kClear ? u_field.ways[k].entry * way.a : way.rgb);
        seen = max(seen, way.a);
        for (int i = 0; i < kCount; ++i)
            sum[i] += light * u_field.ways[k].harmonics[i >> 2][i & 3];
    }
    for (int i = 0; i < kCount; ++i) {
        ivec3 at = node + layer_of(i);
        vec4 light = kAdds ? imageLoad(u_light_img, at) : vec4(0.0);
        imageStore(u_light_img, at, vec4(light.rgb + sum[i], i == 0 ? max(light.a, seen) : 0.0));
    }
}
