// What is scattered at the nodes of another lattice into each way, as this one's nodes have it between them.
//   in   coefficients of what is scattered there; alpha of the first: 0 in nodes that no medium is near to, which are
//        left out of the mean of eight
//   out  radiance that a thick medium of this light would have, of each way [W/m^2/sr]
#include "light/field_pairs.glsl"

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(binding = 0) writeonly uniform uimage3D u_source_img;
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

// @returns how much of the place nodes have that a medium is near to
float add_scattered(vec3 p)
{
    vec3 uvw = first_layer_at(u_field.other, p);
    for (int i = 0; i < kCount; ++i)
        g_light[i] += textureLod(u_scattered_tx, in_layer(u_field.other, uvw, i), 0.0).rgb;
    return textureLod(u_scattered_tx, in_layer(u_field.other, uvw, 0), 0.0).a;
}

void main()
{
    ivec3 node = own_node();
    if (any(greaterThanEqual(node, node_count())))
        return;
    for (int i = 0; i < kCount; ++i)
        g_light[i] = vec3(0.0);
    // Beside a medium a node may have none of the other lattice's near it. What its neighbours have is what goes along
    // the ways between them.
    const float kLeast = 1e-3;
    float near = 0.0;
    for (int j = 0; j < 7; ++j) {
        ivec3 step = ivec3(0);
        if (j > 0)
            step[(j - 1) >> 1] = (j & 1) * 2 - 1;
        if (j == 1 && near > kLeast)
            break;
        near += add_scattered(node_position(u_field.nodes, node + step));
    }
    for (int i = 0; i < kCount; ++i)
        g_light[i] /= max(near, 1e-6);
    FOR_PAIRS_OF_26(SPREAD, 0)
    FOR_PAIRS_OF_48(SPREAD, 26)
}
