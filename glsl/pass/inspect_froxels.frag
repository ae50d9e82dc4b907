// An inspection of the froxels, each pixel as the column that it is in.
//   in   the source of the froxels: radiance added per slices.depth metres
//   out  of one slice, the mean of its channels [W/m^2/sr/m]
#include "lib/channels.glsl"
#include "scene/froxels.glsl"
#include "scene/inspect.glsl"

// Variant. in: the media's evaluations by froxel; out: their sum over the column
const bool kSamples = false;

layout(binding = INSPECTED_UNIT) uniform sampler3D u_froxels_tx;
layout(location = 0) out float out_value;

void main()
{
    ivec2 column = ivec2(columns_at(gl_FragCoord.xy));
    float sum = 0.0;
    for (int k = 0; kSamples && k < froxel_count().z; ++k)
        sum += texelFetch(u_froxels_tx, ivec3(column, k), 0).r;
    vec3 source = texelFetch(u_froxels_tx, ivec3(column, u_inspect.slice), 0).rgb;
    out_value = kSamples ? sum : mean(source) / u_froxels.slices.depth;
}
