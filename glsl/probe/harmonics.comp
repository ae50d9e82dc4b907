// A probe's light as nine harmonics, each times what the cosine leaves of its band: Ramamoorthi and Hanrahan 2001,
// "An Efficient Representation for Irradiance Environment Maps".
//   in   one of the means that the probe is filtered from
//   out  irradiance [W/m^2] by normal
#include "lib/octahedral.glsl"
#include "lib/phase.glsl"
#include "shared/probe_params.h"
#include "shared/spherical_harmonics.h"

const int kThreads = 64;
layout(local_size_x = kThreads) in;
layout(std140, binding = PROBE_FILTER_BLOCK) uniform ProbeFilter { ProbeFilterParams u_filter; };
layout(rgba32f, binding = 0) writeonly uniform image2DArray u_maps_img;
layout(binding = PROBE_SOURCE_UNIT) uniform sampler2DArray u_source_tx;

shared vec4 s_sums[kThreads];
shared float s_weights[kThreads];

void main()
{
    const float kCosine[kProbeHarmonics] =
        float[kProbeHarmonics](kPi, 2.0 / 3.0 * kPi, 2.0 / 3.0 * kPi, 2.0 / 3.0 * kPi, 0.25 * kPi, 0.25 * kPi,
                               0.25 * kPi, 0.25 * kPi, 0.25 * kPi);
    int thread = int(gl_LocalInvocationIndex);
    int n = u_filter.from.size;
    for (int k = 0; k < kProbeHarmonics; ++k) {
        vec4 sum = vec4(0.0);
        float weights = 0.0;
        for (int i = thread; i < n * n; i += kThreads) {
            ivec2 texel = ivec2(i % n, i / n);
            vec3 met = on_octahedron((vec2(texel) + 0.5) / float(n));
            float weight = octahedral_solid_angle(met, float(n));
            vec4 light = texelFetch(u_source_tx, ivec3(u_filter.from.first + texel, u_filter.from.layer), 0);
            sum += weight * spherical_harmonic(k, normalize(met)) * light;
            weights += weight;
        }
        s_sums[thread] = sum;
        s_weights[thread] = weights;
        barrier();
        if (thread == 0) {
            for (int i = 1; i < kThreads; ++i) {
                sum += s_sums[i];
                weights += s_weights[i];
            }
            // The texels' middles stand for their solid angles but nearly.
            imageStore(u_maps_img, ivec3(u_filter.to.first + ivec2(k, 0), u_filter.to.layer),
                       sum * (kCosine[k] * 4.0 * kPi / weights));
        }
        barrier();
    }
}
