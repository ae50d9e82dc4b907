// Light from a probe's layer: shared/probe_params.h.
#include "lib/octahedral.glsl"
#include "shared/probe_params.h"
#include "shared/spherical_harmonics.h"

// Which two of the maps a surface of GGX's alpha is between, and how far: their mean has the width of its lobe, whose
// variance is alpha^2 to a factor.
struct ProbeLevel {
    int lower;
    float part;
};

ProbeLevel probe_level(float last, float alpha)
{
    float level = clamp(last + log2(max(alpha, 1e-6)), 0.0, last - 0.001);
    float lower = floor(level);
    float narrow = lower > 0.0 ? exp2(lower - last) : 0.0;
    float wide = exp2(lower + 1.0 - last);
    return ProbeLevel(int(lower), clamp((alpha * alpha - narrow * narrow) / (wide * wide - narrow * narrow), 0.0, 1.0));
}

// at: first and size of a map
vec4 probe_map_at(sampler2DArray maps_tx, vec4 at, int layer, vec2 uv)
{
    return textureLod(maps_tx, vec3(at.xy + at.zw * uv, float(layer)), 0.0);
}

// [W/m^2]; n: unit length. Bands 0 to 2 of a bright light and the cosine dip below 0 behind it.
vec4 probe_irradiance(sampler2DArray maps_tx, int row, int layer, vec3 n)
{
    vec4 sum = vec4(0.0);
    for (int k = 0; k < kProbeHarmonics; ++k)
        sum += texelFetch(maps_tx, ivec3(k, row, layer), 0) * spherical_harmonic(k, n);
    return max(sum, vec4(0.0));
}
