// Coefficients of light at nodes, evened out with those of the two neighbours along an axis, where no surface stands between:
// what changes linearly from node to node stays as it is.
//   in   the coefficients; clearance
//   out  the same
#include "light/field.glsl"
#include "light/clearance.glsl"
#include "shared/spherical_harmonics.h"

// Variant
const int kBands = 1;
const int kAxis = 0;

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(rgba32f, binding = 0) writeonly uniform image3D u_light_img;
layout(binding = FIELD_LIGHT_UNIT) uniform sampler3D u_light_tx;

void main()
{
    ivec3 node = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(node, node_count())))
        return;
    ivec3 step = ivec3(kAxis == 0, kAxis == 1, kAxis == 2);
    uvec2 clearance = texelFetch(u_crossed_tx, node, 0).rg;
    vec3 walls = min(unpack_clearance(clearance, bvec3(false)).wall, unpack_clearance(clearance, bvec3(true)).wall);
    bool is_open = walls[kAxis] > 1.0 && node[kAxis] > 0 && node[kAxis] < node_count()[kAxis] - 1;
    for (int i = 0; i < kHarmonics[kBands - 1]; ++i) {
        ivec3 at = node + layer_of(i);
        vec4 light = texelFetch(u_light_tx, at, 0);
        if (is_open)
            light.rgb = 0.5 * light.rgb +
                        0.25 * (texelFetch(u_light_tx, at - step, 0).rgb + texelFetch(u_light_tx, at + step, 0).rgb);
        imageStore(u_light_img, at, light);
    }
}
