// What panes and the media before and between them add, for each ray of the march: one look-up of it stands for one
// before each pane.
//   in   what the march kept at each pane's depth; the layer's depth
//   out  radiance that is added, and which panes the ray meets before its surface: a sum of powers of two
#include "scene/panes.glsl"
#include "scene/volume_at_splits.glsl"

// Variant
const int kPaneCount = 1;     // as many as there may be
const bool kNoMedia = false;  // in tiles that keep nothing

layout(location = 0) out vec4 out_added;

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    vec2 pixel = (gl_FragCoord.xy + u_frame.layer_offset) * float(kLayerScale);
    vec2 ndc = pixel * u_frame.inverse_full_size * 2.0 - 1.0;
    vec2 view_z = vec2(u_panes.view_z.x, min(texelFetch(u_layer_depth_tx, texel, 0).r, u_panes.view_z.y));
    vec4 added = vec4(0.0);
    for (int k = kPaneCount - 1; k >= 0; --k) {
        VolumeAt at = VolumeAt(vec3(0.0), vec3(1.0));
        if (!kNoMedia)
            at = split_texel(texel, min(k, u_panes.count - 1));
        vec3 kept = u_panes.kept[k].rgb;
        vec3 here = added.rgb * kept + added_in_volume(at, u_panes.emitted[k].rgb, kept);
        added = mix(added, vec4(here, added.a + float(1 << k)),
                    bvec4(k < u_panes.count ? pane_seen(pane_hit(k, ndc), view_z) : 0.0));
    }
    out_added = added;
}
