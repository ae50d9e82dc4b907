// What each order of scattering has brought: the mean over the nodes of its radiance, weighted by what scatters it
// again.
//   in   mean radiance of all orders so far at each node; sigma_t and albedo
//   out  of each slice of nodes along z the sum of the weighted radiance, and of the weights, a row an order
//   kFinish: from those, mean radiance that each order added [W/m^2/sr], a texel an order
#include "light/field.glsl"

// Variant
const bool kFinish = false;  // sums up the slices

layout(local_size_x = 64) in;
layout(binding = 0) writeonly uniform image3D u_sums_img;
layout(binding = FIELD_LIGHT_UNIT) uniform sampler3D u_slices_tx;
layout(binding = FIELD_WAYS_UNIT) uniform usampler3D u_mean_tx;
layout(binding = FIELD_SIGMA_T_UNIT) uniform sampler3D u_sigma_t_tx;
layout(binding = FIELD_ALBEDO_UNIT) uniform sampler3D u_albedo_tx;

shared vec3 g_light[64];
shared vec3 g_weights[64];

vec3 mean_to(int order)
{
    if (order < 0)
        return vec3(0.0);
    vec3 light = vec3(0.0);
    vec3 weights = vec3(0.0);
    for (int slice = 0; slice < node_count().z; ++slice) {
        light += texelFetch(u_slices_tx, ivec3(2 * slice, order, 0), 0).rgb;
        weights += texelFetch(u_slices_tx, ivec3(2 * slice + 1, order, 0), 0).rgb;
    }
    return light / max(weights, vec3(1e-30));
}

void main()
{
    int own = int(gl_LocalInvocationIndex);
    if (kFinish) {
        int order = int(gl_GlobalInvocationID.x);
        if (order <= u_field.order)
            imageStore(u_sums_img, ivec3(order, 0, 0), vec4(mean_to(order) - mean_to(order - 1), 0.0));
        return;
    }
    int slice = int(gl_WorkGroupID.z);
    ivec2 size = node_count().xy;
    vec3 light = vec3(0.0);
    vec3 weights = vec3(0.0);
    for (int i = own; i < size.x * size.y; i += 64) {
        ivec3 node = ivec3(i % size.x, i / size.x, slice);
        vec3 weight = texelFetch(u_sigma_t_tx, node, 0).rgb * texelFetch(u_albedo_tx, node, 0).rgb;
        light += weight * unpack_light(texelFetch(u_mean_tx, node, 0).rg);
        weights += weight;
    }
    g_light[own] = light;
    g_weights[own] = weights;
    barrier();
    if (own > 0)
        return;
    for (int i = 1; i < 64; ++i) {
        light += g_light[i];
        weights += g_weights[i];
    }
    imageStore(u_sums_img, ivec3(2 * slice, u_field.order, 0), vec4(light, 0.0));
    imageStore(u_sums_img, ivec3(2 * slice + 1, u_field.order, 0), vec4(weights, 0.0));
}
