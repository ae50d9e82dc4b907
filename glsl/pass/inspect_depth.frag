// An inspection: view_z [m] of the scene's surfaces, nothing in the sky.
//   in   the host's depth
#include "lib/depth.glsl"
#include "lib/false_color.glsl"
#include "scene/frame.glsl"

layout(binding = SCENE_DEPTH_UNIT) uniform sampler2D u_scene_depth_tx;
layout(location = 0) out float out_value;

void main()
{
    float depth = texelFetch(u_scene_depth_tx, ivec2(gl_FragCoord.xy), 0).r;
    out_value = min(view_z_of(depth, u_frame.view_z_from_depth, u_frame.sky_depth), kNothing);
}
