// One surface into one view of the shadow map: linear depth (lib/shadow.glsl).
#include "lib/shadow.glsl"
#include "shared/bindings.h"
#include "shared/draw_params.h"

layout(std140, binding = DRAW_BLOCK) uniform Draw { DrawParams u_draw; };
in vec3 p_world;  // light-centred here

void main() { gl_FragDepth = shadow_depth(u_draw.shadow_depth, p_world); }
