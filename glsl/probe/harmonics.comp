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

void main()
{
    const float kCosine[kProbeHarmonics] =
        float[kProbeHarmonics](kPi, 2.0 / 3.0 * kPi, 2.0 / 3.0 * kPi, 2.0 / 3.0 * kPi, 0.25 * kPi, 0.25 * kPi,
                               0.25 * kPi, 0.25 * kPi, 0.25 * kPi);
    int thread = int(gl_LocalInvocationIndex);
    int n = u_filter.from.size;
    vec4 sums[kProbeHarmonics];
    for (int k = 0; k < kProbeHarmonics; ++k)
        sums[k] = vec4(0.0);
    for (int i = thread; i < n * n; i += kThreads) {
        ivec2 texel = ivec2(i % n, i / n);
        vec3 met = on_octahedron((vec2(texel) + 0.5) / float(n));
        vec3 d = normalize(met);
        vec3 light = texelFetch(u_source_tx, ivec3(u_filter.from.first + texel, u_filter.from.layer), 0).rgb;
        vec4 weighed = octahedral_solid_angle(met, float(n)) * vec4(light, 1.0);
        sums[0] += weighed * spherical_harmonic(0, d);
        for (int k = 1; k < kProbeHarmonics; ++k)
            sums[k].rgb += weighed.rgb * spherical_harmonic(k, d);
    }
    float weights = 0.0;
    for (int k = 0; k < kProbeHarmonics; ++k) {
        s_sums[thread] = sums[k];
        barrier();
        if (thread == 0) {
            vec4 sum = vec4(0.0);
            for (int i = 0; i < kThreads; ++i)
                sum += s_sums[i];
            if (k == 0)
                weights = sum.a / spherical_harmonic(0, vec3(0.0));
            // The texels' middles stand for their solid angles but nearly.
            imageStore(u_maps_img, ivec3(u_filter.to.first + ivec2(k, 0), u_filter.to.layer),
                       vec4(sum.rgb * (kCosine[k] * 4.0 * kPi / weights), 0.0));
        }
        barrier();
    }
}
