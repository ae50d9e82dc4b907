// What an order of scattering has brought: the mean over the nodes of its radiance, weighted by what scatters it
// again.
//   in   coefficients of the order; sigma_t and albedo
//   out  mean radiance [W/m^2/sr], a texel an order
#include "light/field.glsl"

layout(local_size_x = 64) in;
layout(binding = 0) writeonly uniform image3D u_sums_img;
layout(binding = FIELD_LIGHT_UNIT) uniform sampler3D u_light_tx;
layout(binding = FIELD_SIGMA_T_UNIT) uniform sampler3D u_sigma_t_tx;
layout(binding = FIELD_ALBEDO_UNIT) uniform sampler3D u_albedo_tx;

shared vec3 g_light[64];
shared vec3 g_weights[64];

void main()
{
    ivec3 size = ivec3(u_field.nodes.last) + 1;
    int nodes = size.x * size.y * size.z;
    vec3 light = vec3(0.0);
    vec3 weights = vec3(0.0);
    int own = int(gl_LocalInvocationIndex);
    for (int i = own; i < nodes; i += 64) {
        ivec3 node = ivec3(i % size.x, i / size.x % size.y, i / (size.x * size.y));
        vec3 weight = texelFetch(u_sigma_t_tx, node, 0).rgb * texelFetch(u_albedo_tx, node, 0).rgb;
        light += weight * texelFetch(u_light_tx, node, 0).rgb;
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
    const float kMean = 0.282094791773878;  // of the first harmonic
    imageStore(u_sums_img, ivec3(u_field.order, 0, 0), vec4(kMean * light / max(weights, vec3(1e-30)), 0.0));
}
