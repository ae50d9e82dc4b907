// What panes and the media before and between them add, for each ray of the march: one look-up of it stands for one
// before each pane.
//   in   what the march kept at each pane's depth; the layer's depth
//   out  radiance that is added, and which panes the ray meets before its surface: a sum of powers of two
#include "scene/panes.glsl"
#include "scene/volume_at_splits.glsl"

// Variant
const int kPaneCount = 1;  // as many as there may be

noperspective in vec4 pane_hits[kPaneCount];
flat in vec3 pane_kept[kPaneCount];
layout(location = 0) out vec4 out_added;

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    vec2 view_z = vec2(u_panes.view_z.x, min(texelFetch(u_layer_depth_tx, texel, 0).r, u_panes.view_z.y));
    vec4 added = vec4(0.0);
    for (int k = kPaneCount - 1; k >= 0; --k) {
        VolumeAt at = split_texel(texel, min(k, u_panes.count - 1));
        vec3 kept = pane_kept[k];
        vec3 here = added.rgb * kept + at.transmittance * u_panes.emitted[k].rgb + at.scattering * (1.0 - kept);
        added = mix(added, vec4(here, added.a + float(1 << k)), bvec4(pane_seen(pane_hits[k], view_z)));
    }
    out_added = added;
}
