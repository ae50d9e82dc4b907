// A map of a probe's to one of half its size, each texel the mean of four by solid angle.
#include "probe/map.glsl"

layout(binding = PROBE_SOURCE_UNIT) uniform sampler2DArray u_source_tx;

void main()
{
    if (!is_in_map())
        return;
    ivec2 texel = 2 * texel_of_map();
    float n = float(u_filter.from.size);
    vec4 means[4];
    vec4 sum = vec4(0.0);
    float weights = 0.0;
    for (int k = 0; k < 4; ++k) {
        ivec2 one = texel + ivec2(k & 1, k >> 1);
        float weight = octahedral_solid_angle(on_octahedron((vec2(one) + 0.5) / n), n);
        means[k] = texelFetch(u_source_tx, ivec3(u_filter.from.first + one, u_filter.from.layer), 0);
        sum += weight * (means[k] - means[0]);
        weights += weight;
    }
    store(means[0] + sum / weights);
}
