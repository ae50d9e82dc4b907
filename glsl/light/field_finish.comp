// Light at the nodes of a lattice as it is looked up.
//   in   coefficients of the world's light or, kField, of what is scattered again and emitted, of all that is scattered,
//        and of the world's light, as it is looked up without the others
//   out  their sum [W/m^2/sr]; alpha of the first: 0 inside of surfaces, which most ways tell
#include "light/field_listed.glsl"
#include "shared/spherical_harmonics.h"

// Variant
const int kBands = 1;
const bool kField = false;
const bool kWorld = false;  // there is light of the world beside the field
const bool kHole = false;   // nodes in a box are left out, as are those inside of surfaces

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(binding = 0) writeonly uniform image3D u_field_img;
layout(binding = FIELD_LIGHT_UNIT) uniform sampler3D u_light_tx;
layout(binding = FIELD_WORLD_UNIT) uniform sampler3D u_world_coefficients_tx;
layout(binding = FIELD_ORDER_UNIT) uniform sampler3D u_total_tx;

void main()
{
    const int kCount = kHarmonics[kBands - 1];
    ivec3 node = own_node();
    if (any(greaterThanEqual(node, node_count())))
        return;
    float seen = kField ? texelFetch(u_total_tx, node, 0).a : step(0.5, texelFetch(u_light_tx, node, 0).a);
    if (kWorld)
        seen = max(seen, step(0.5, texelFetch(u_world_coefficients_tx, node, 0).a));
    if (kField && seen == 0.0) {
        // No lamp or sky is seen from here, but light may come by way of others: a place inside of a surface has no
        // more than what its neighbours let shine through.
        const float kShine = 0.1;
        vec3 own = texelFetch(u_light_tx, node, 0).rgb;
        vec3 around = vec3(0.0);
        for (int j = 0; j < 6; ++j) {
            ivec3 way = ivec3(0);
            way[j >> 1] = (j & 1) * 2 - 1;
            ivec3 next = clamp(node + way, ivec3(0), node_count() - 1);
            around = max(around, texelFetch(u_light_tx, next, 0).rgb);
        }
        seen = dot(own, vec3(1.0)) > kShine * dot(around, vec3(1.0)) ? 1.0 : 0.0;
    }
    if (kHole && all(greaterThan(vec3(node), u_field.hole_low)) && all(lessThan(vec3(node), u_field.hole_high)))
        seen = 0.0;
    // What is left out of the mean of eight nodes must have no light either.
    for (int i = 0; i < kCount; ++i) {
        ivec3 at = node + layer_of(i);
        vec3 light = texelFetch(u_light_tx, at, 0).rgb;
        if (kWorld)
            light += texelFetch(u_world_coefficients_tx, at, 0).rgb;
        imageStore(u_field_img, at, seen * vec4(light, i == 0 ? 1.0 : 0.0));
    }
}
