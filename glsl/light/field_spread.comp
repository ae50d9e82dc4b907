// What is scattered at the nodes of another lattice into each way, as this one's nodes have it between them.
//   in   coefficients of what is scattered there
//   out  radiance that a thick medium of this light would have, of each way [W/m^2/sr]
#include "light/field_pairs.glsl"

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(r32ui, binding = 0) writeonly uniform uimage3D u_source_img;
layout(binding = FIELD_LIGHT_UNIT) uniform sampler3D u_scattered_tx;

// Variant
const int kWays = 0;  // of the batch, where its size is one of the usual two

#define SPREAD(k)                                \
    if (k < (kWays > 0 ? kWays : u_field.count)) \
        spread_pair(node, k);

void spread_pair(ivec3 node, int k)
{
    vec3 even, odd;
    sum_pair(k, even, odd);
    imageStore(u_source_img, node + way_of(k), pack_light(even + odd, node + way_of(k)));
    imageStore(u_source_img, node + way_of(k + 1), pack_light(even - odd, node + way_of(k + 1)));
}

void main()
{
    ivec3 node = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(node, node_count())))
        return;
    vec3 uvw = first_layer_at(u_field.other, node_position(u_field.nodes, node));
    for (int i = 0; i < kCount; ++i)
        g_light[i] = textureLod(u_scattered_tx, in_layer(u_field.other, uvw, i), 0.0).rgb;
    FOR_PAIRS_OF_26(SPREAD, 0)
    FOR_PAIRS_OF_48(SPREAD, 26)
}
