// The layer's depth by fragments: pass/layer_depth.glsl.
#include "pass/layer_depth.glsl"

layout(location = 0) out float out_view_z;

void main() { out_view_z = layer_view_z(ivec2(gl_FragCoord.xy)); }
