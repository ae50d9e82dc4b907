// A frame, to be blended into the mean of those before it.
#include "shared/bindings.h"

layout(binding = DISPLAY_A_UNIT) uniform sampler2D u_frame_tx;
layout(location = 0) out vec4 out_color;

void main() { out_color = vec4(texelFetch(u_frame_tx, ivec2(gl_FragCoord.xy), 0).rgb, 1.0); }
