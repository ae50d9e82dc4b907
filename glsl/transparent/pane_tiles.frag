// Lays panes over tiles of which every ray meets the same (transparent/pane_tiles.vert), but for pixels before whose
// surface they are not, or of a march whose rays around them meet a surface before the last.
//   in   as transparent/panes.frag
//   out  likewise
#include "lib/depth.glsl"
#include "scene/frame.glsl"

// Variant
const bool kNoMedia = false;  // those that see no medium; else the others

layout(binding = SCENE_DEPTH_UNIT) uniform sampler2D u_scene_depth_tx;
layout(binding = PANE_LAYER_UNIT) uniform sampler2D u_pane_layer_tx;
flat in vec3 panes_emitted;
flat in vec3 panes_kept;
flat in vec2 panes_farthest;
layout(location = 0, index = 0) out vec4 out_added;
layout(location = 0, index = 1) out vec4 out_kept;

void main()
{
    float scene_z = view_z_of(texelFetch(u_scene_depth_tx, ivec2(gl_FragCoord.xy), 0).r, u_frame.view_z_from_depth,
                              u_frame.sky_depth);
    vec4 added = vec4(panes_emitted, panes_farthest.y);
    if (!kNoMedia) {
        vec2 texel = gl_FragCoord.xy / float(kLayerScale) - u_frame.layer_offset;
        added = textureLod(u_pane_layer_tx, texel * u_frame.inverse_layer_size, 0.0);
    }
    // No ray meets another pane, so that a mean of four is the sum of all if each is.
    if (!(scene_z > panes_farthest.x && added.a == panes_farthest.y))
        discard;
    out_added = vec4(added.rgb, 1.0);
    out_kept = vec4(panes_kept, 1.0);
}
