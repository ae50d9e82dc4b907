// An inspection of the march: the media's evaluations by each pixel's ray, that of the nearest texel of the
// layer.
//   in   evaluations by texel
#include "scene/frame.glsl"

layout(binding = INSPECTED_UNIT) uniform sampler2D u_counts_tx;
layout(location = 0) out float out_value;

void main()
{
    ivec2 texel = ivec2(floor(gl_FragCoord.xy / float(kLayerScale) - u_frame.layer_offset));
    out_value = texelFetch(u_counts_tx, clamp(texel, ivec2(0), textureSize(u_counts_tx, 0) - 1), 0).r;
}
