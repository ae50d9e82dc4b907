// Sums what a batch of directions brings to each node, as harmonics.
//   in   radiance at the columns' places
//   out  coefficients of this light, and of all orders so far
#include "light/field.glsl"
#include "lib/spherical_harmonics.glsl"

// Variant
const int kBands = 1;
const bool kFirstBatch = false;  // what was there is of no use
const bool kTotal = false;       // summed over the orders too

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(rgba32f, binding = 0) uniform image3D u_light_img;
layout(rgba32f, binding = 1) uniform image3D u_total_img;
layout(binding = FIELD_COLUMNS_UNIT) uniform sampler3D u_columns_tx;

void main()
{
    const int kCount = kHarmonics[kBands - 1];
    ivec3 node = ivec3(gl_GlobalInvocationID);
    LatticeParams lattice = u_field.nodes;
    if (any(greaterThan(node, ivec3(lattice.last))))
        return;
    ivec3 layer = ivec3(0, 0, int(lattice.last.z) + 1);
    vec3 texel = 1.0 / vec3(vec2(u_field.columns), u_field.slices * u_field.count);
    vec3 sum[kCount];
    for (int i = 0; i < kCount; ++i)
        sum[i] = vec3(0.0);
    for (int k = 0; k < u_field.count; ++k) {
        FieldDirection d = u_field.directions[k];
        vec3 q = to_axes(d.axis, vec3(node));
        float slice = d.forward > 0.0 ? q.x : to_axes(d.axis, lattice.last).x - q.x;
        vec2 column = q.yz - d.slope * slice - d.first;
        vec3 uvw = (vec3(column, slice + float(u_field.slices * k)) + 0.5) * texel;
        vec3 light = textureLod(u_columns_tx, uvw, 0.0).rgb * d.solid_angle;
        for (int i = 0; i < kCount; ++i)
            sum[i] += light * spherical_harmonic(i, d.wi);
    }
    for (int i = 0; i < kCount; ++i) {
        ivec3 at = node + layer * i;
        vec4 light = kFirstBatch ? vec4(0.0) : imageLoad(u_light_img, at);
        imageStore(u_light_img, at, vec4(light.rgb + sum[i], light.a));
        if (kTotal) {
            vec4 total = imageLoad(u_total_img, at);
            imageStore(u_total_img, at, vec4(total.rgb + sum[i], total.a));
        }
    }
}
