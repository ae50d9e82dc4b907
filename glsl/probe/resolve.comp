// Light from all around to an octahedral map: each texel the mean over it.
//   in   a latitude-longitude map, or the six faces of a cube
//   out  radiance
#include "lib/cube_faces.glsl"
#include "lib/lat_long.glsl"
#include "probe/map.glsl"

// Variant. FACES: of a cube.
const int kSamples = 2;  // along a texel's edges, no further apart than what they are taken from

#ifdef FACES
layout(binding = PROBE_SOURCE_UNIT) uniform sampler2DArray u_source_tx;
vec4 light_from(vec3 d) { return textureLod(u_source_tx, cube_face(d), 0.0); }
#else
layout(binding = PROBE_SOURCE_UNIT) uniform sampler2D u_source_tx;
vec4 light_from(vec3 d) { return textureLod(u_source_tx, lat_long_uv(normalize(d)), 0.0); }
#endif

void main()
{
    if (!is_in_map())
        return;
    vec2 texel = vec2(texel_of_map());
    float n = float(u_filter.to.size);
    vec4 middle = light_from(on_octahedron((texel + 0.5) / n));
    vec4 sum = vec4(0.0);
    float weights = 0.0;
    for (int j = 0; j < kSamples; ++j)
        for (int i = 0; i < kSamples; ++i) {
            vec3 met = on_octahedron((texel + (vec2(i, j) + 0.5) / float(kSamples)) / n);
            float weight = octahedral_solid_angle(met, n);
            sum += weight * (light_from(met) - middle);
            weights += weight;
        }
    store(middle + sum / weights);
}
