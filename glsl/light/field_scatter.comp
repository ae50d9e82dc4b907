// What the media scatter at each node into each direction of a batch: the phase function's bands against the light's,
// Henyey-Greenstein's l-th times g^l.
// Orders that were not carried are taken to fall off as the last two did: a geometric series. Hillaire 2020, "A
// Scalable and Production Ready Sky and Atmosphere Rendering Technique", sec. 5.5.
//   in   coefficients of the light that arrives; albedo and g; kTail: of the last order, and each order's mean
//   out  radiance that a thick medium of this light would have, a direction a layer [W/m^2/sr]
#include "light/field.glsl"
#include "lib/spherical_harmonics.glsl"

// Variant
const int kBands = 1;
const bool kTail = false;  // orders are left out

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(binding = 0) writeonly uniform image3D u_source_img;
layout(binding = FIELD_LIGHT_UNIT) uniform sampler3D u_light_tx;
layout(binding = FIELD_ALBEDO_UNIT) uniform sampler3D u_albedo_tx;
layout(binding = FIELD_ORDER_UNIT) uniform sampler3D u_last_order_tx;
layout(binding = FIELD_SUMS_UNIT) uniform sampler3D u_sums_tx;

vec3 tail_of_last_order()
{
    const float kMostRatio = 0.98;
    vec3 last = texelFetch(u_sums_tx, ivec3(u_field.order, 0, 0), 0).rgb;
    vec3 before = texelFetch(u_sums_tx, ivec3(u_field.order - 1, 0, 0), 0).rgb;
    vec3 ratio = clamp(last / max(before, vec3(1e-30)), 0.0, kMostRatio);
    return ratio / (1.0 - ratio);
}

void main()
{
    const int kCount = kHarmonics[kBands - 1];
    ivec3 node = ivec3(gl_GlobalInvocationID);
    LatticeParams lattice = u_field.nodes;
    if (any(greaterThan(node, ivec3(lattice.last))))
        return;
    ivec3 layer = ivec3(0, 0, int(lattice.last.z) + 1);
    vec4 albedo = texelFetch(u_albedo_tx, node, 0);
    vec3 light[16];
    vec3 scattered = albedo.rgb;
    vec3 tail = kTail ? tail_of_last_order() : vec3(0.0);
    int i = 0;
    for (int l = 0; l < kBands; ++l) {
        for (; i < kHarmonics[l]; ++i) {
            light[i] = texelFetch(u_light_tx, node + layer * i, 0).rgb;
            if (kTail)
                light[i] += tail * texelFetch(u_last_order_tx, node + layer * i, 0).rgb;
            light[i] *= scattered;
        }
        scattered *= albedo.a;
    }
    for (int k = 0; k < u_field.count; ++k) {
        vec3 sum = vec3(0.0);
        for (int j = 0; j < kCount; ++j)
            sum += light[j] * spherical_harmonic(j, u_field.directions[k].wi);
        imageStore(u_source_img, node + layer * k, vec4(sqrt(sqrt(max(sum, vec3(0.0)))), 0.0));
    }
}
