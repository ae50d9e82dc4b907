// A picture of values in false colours; where there is none the host's picture stays.
//   in   values, kNothing where there are none
//   out  linear colour for a screen at exposure 0
#include "lib/false_color.glsl"
#include "scene/inspect.glsl"

layout(binding = INSPECTED_UNIT) uniform sampler2D u_values_tx;
layout(location = 0) out vec4 out_color;

void main()
{
    float value = texelFetch(u_values_tx, ivec2(gl_FragCoord.xy), 0).r;
    if (!(value < kNothing))
        discard;
    out_color = vec4(magma((value - u_inspect.scale_begin) * u_inspect.inverse_scale_width), 1.0);
}
