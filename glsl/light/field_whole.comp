// What is scattered, of the whole phase function and extinction, from what is without the forward peak.
//   in   albedo of the rest, and g
//   io   coefficients of what is scattered
#include "light/field_listed.glsl"
#include "light/forward_peak.glsl"
#include "shared/spherical_harmonics.h"

const int kBands = 1;  // variant

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(rgba32f, binding = 0) uniform image3D u_light_img;
layout(binding = FIELD_ALBEDO_UNIT) uniform sampler3D u_albedo_tx;

void main()
{
    ivec3 node = own_node();
    if (any(greaterThanEqual(node, node_count())))
        return;
    vec4 albedo = texelFetch(u_albedo_tx, node, 0);
    vec3 peak = forward_peak_by_rest(albedo.rgb, albedo.a, u_field.straight_on);
    vec3 extinction = rest_of_extinction_by_rest(albedo.rgb, peak);
    // The whole's band over the rest's. A peak is at most g^4, a band at least g^3.
    float power = 1.0;
    int i = 0;
    for (int l = 0; l < kBands; ++l) {
        vec3 band = peak.r > 0.0 ? power / (power - peak) : vec3(1.0);
        for (; i < kHarmonics[l]; ++i) {
            vec4 light = imageLoad(u_light_img, node + layer_of(i));
            imageStore(u_light_img, node + layer_of(i), vec4(light.rgb * extinction * band, light.a));
        }
        power *= albedo.a;
    }
}
