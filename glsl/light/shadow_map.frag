// One surface into one view of the shadow map: linear depth (lib/shadow.glsl).
#include "lib/shadow.glsl"
#include "shared/bindings.h"
#include "shared/draw_params.h"

// Variant
const bool kHalfway = false;  // a solid's depth is halfway from its near side to its far side

layout(std140, binding = DRAW_BLOCK) uniform Draw { DrawParams u_draw; };
layout(binding = SHADOW_MAP_UNIT) uniform sampler2D u_backs_tx;  // nearest far sides' depths, while the map is drawn
in vec3 p_world;                                                 // light-centred here

void main()
{
    float depth = shadow_depth(u_draw.shadow_depth, p_world);
    if (kHalfway && gl_FrontFacing) {
        float back = texelFetch(u_backs_tx, ivec2(gl_FragCoord.xy), 0).r;
        if (back < 1.0)
            depth = mix(depth, back, 0.5);
    }
    gl_FragDepth = depth;
}
