// An inspection of the froxels, each pixel as the column that it is in.
//   in   the source of the froxels: radiance added per slices.depth metres
//   out  of one slice, the mean of its channels [W/m^2/sr/m]
//
// Variant: SAMPLES  in: the media's evaluations by froxel; out: their sum over the column
#include "scene/froxels.glsl"
#include "scene/inspect.glsl"

layout(binding = INSPECTED_UNIT) uniform sampler3D u_froxels_tx;
layout(location = 0) out float out_value;

void main()
{
    ivec2 column = ivec2(columns_at(gl_FragCoord.xy));
#ifdef SAMPLES
    float sum = 0.0;
    for (int k = 0; k < froxel_count().z; ++k)
        sum += texelFetch(u_froxels_tx, ivec3(column, k), 0).r;
    out_value = sum;
#else
    vec3 source = texelFetch(u_froxels_tx, ivec3(column, u_inspect.slice), 0).rgb;
    out_value = dot(source, vec3(1.0 / 3.0)) / u_froxels.slices.depth;
#endif
}
