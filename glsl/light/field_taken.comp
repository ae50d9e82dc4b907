// Of light that comes to a node along its near ways, what it takes in counts, as that is what it sends out: each way by
// what light meets on it. Between two nodes that is the mean of their extinctions, half of which is the one's and half
// the other's.
//   in   sigma_t
//   out  light/field_taken.glsl
#include "light/field_listed.glsl"
#include "light/way_pairs.glsl"

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(binding = 0) writeonly uniform image3D u_taken_img;
layout(binding = FIELD_SIGMA_T_UNIT) uniform sampler3D u_sigma_t_tx;

extinction_t sigma_t_at(ivec3 node)
{
    return extinction_t(texelFetch(u_sigma_t_tx, clamp(node, ivec3(0), node_count() - 1), 0).rgb);
}

extinction_t g_taken[FIELD_TAKEN];
extinction_t g_all = extinction_t(0.0);

void take(ivec3 node, int k, extinction_t own)
{
    const float kNone = 1e-20;  // where there is no medium: then all ways are alike
    FieldWay way = u_field.ways[k];
    ivec3 step = from_axes(way.axis, ivec3(way.forward, floor(way.slope + 0.5)));
    g_taken[k / 2] = way.solid_angle * (0.5 * (sigma_t_at(node - step) + sigma_t_at(node + step)) + own + kNone);
    g_all += 2.0 * g_taken[k / 2];
}

void keep(float taken[FIELD_TAKEN], ivec3 node)
{
    for (int i = 0; i < FIELD_TAKEN; i += 4)
        imageStore(u_taken_img, node + layer_of(i / 4), vec4(taken[i], taken[i + 1], taken[i + 2], taken[i + 3]));
}

void keep(vec3 taken[FIELD_TAKEN], ivec3 node)
{
    for (int i = 0; i <= FIELD_TAKEN_OF_CELL; ++i)
        imageStore(u_taken_img, node + layer_of(i), vec4(taken[i], 0.0));
}

const float kSphere = 4.0 * 3.14159265;

#define TAKE(k) take(node, k, own);
#define WEIGH(k) g_taken[k / 2] = g_taken[k / 2] / g_all - u_field.ways[k].solid_angle / kSphere;

void main()
{
    ivec3 node = own_node();
    if (any(greaterThanEqual(node, node_count())))
        return;
    extinction_t own = sigma_t_at(node);
    FOR_PAIRS_OF_26(TAKE, 0)
    FOR_PAIRS_OF_26(WEIGH, 0)
    g_taken[FIELD_TAKEN_OF_CELL] = 2.0 * kSphere * own / g_all;
    for (int i = FIELD_TAKEN_OF_CELL + 1; i < FIELD_TAKEN; ++i)
        g_taken[i] = extinction_t(0.0);
    keep(g_taken, node);
}
