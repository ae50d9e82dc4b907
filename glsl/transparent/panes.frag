// Lays panes that are in order over the picture, which has the media and the surfaces already: what
// transparent/resolve.frag does with lists, without any.
//   in   the host's depth; of a march what panes add to each ray (transparent/pane_layer.frag); what the media do before
//        any depth
//   out  what the picture is multiplied with, the second source of blending, and what is added to it
#include "lib/depth.glsl"
#include "scene/panes.glsl"
#include "written/volume_at.glsl"

// Variant
const int kPaneCount = 1;       // as many as there may be
const bool kPaneLayer = false;  // of the layer, and pane by pane where it does not do; else pane by pane
const bool kNoMedia = false;    // nor this, where no medium is seen

layout(binding = SCENE_DEPTH_UNIT) uniform sampler2D u_scene_depth_tx;
layout(binding = PANE_LAYER_UNIT) uniform sampler2D u_pane_layer_tx;
noperspective in vec4 pane_hits[kPaneCount];
layout(location = 0, index = 0) out vec4 out_added;
layout(location = 0, index = 1) out vec4 out_kept;

// What the panes that are met add, one after the other.
vec3 added_by_panes(uint met)
{
    VolumeRay ray = volume_ray(gl_FragCoord.xy);
    vec2 ndc = gl_FragCoord.xy * u_frame.inverse_full_size * 2.0 - 1.0;
    vec3 added = vec3(0.0);
    do {
        int k = findMSB(met);
        VolumeAt at = volume_at_pane(ray, k, pane_view_z(pane_hit(k, ndc)));
        vec3 kept = u_panes.kept[k].rgb;
        added = added * kept + added_in_volume(at, u_panes.emitted[k].rgb, kept);
        met ^= 1u << uint(k);
    } while (met != 0u);
    return added;
}

void main()
{
    float scene_z = view_z_of(texelFetch(u_scene_depth_tx, ivec2(gl_FragCoord.xy), 0).r, u_frame.view_z_from_depth,
                              u_frame.sky_depth);
    vec2 view_z = vec2(u_panes.view_z.x, min(scene_z, u_panes.view_z.y));
    float met = 0.0;
    vec3 kept = vec3(1.0), added = vec3(0.0);
    for (int k = kPaneCount - 1; k >= 0; --k) {
        float seen = pane_seen(pane_hits[k], view_z);
        met += seen * float(1 << k);
        if (kNoMedia)
            added = mix(added, added * u_panes.kept[k].rgb + u_panes.emitted[k].rgb, bvec3(seen));
        kept = mix(kept, kept * u_panes.kept[k].rgb, bvec3(seen));
    }
    out_kept = vec4(kept, 1.0);
    if (kNoMedia) {
        out_added = vec4(added, 1.0);
        return;
    }
    uint left = uint(met);
    if (kPaneLayer) {
        // The layer does where all four rays around the pixel meet the panes that it meets, and no others.
        vec2 texel = gl_FragCoord.xy / float(kLayerScale) - 0.5 - u_frame.layer_offset;
        vec2 middle = (floor(texel) + 1.0) * u_frame.inverse_layer_size;
        if (textureGather(u_pane_layer_tx, middle, 3) == vec4(met)) {
            added = textureLod(u_pane_layer_tx, (texel + 0.5) * u_frame.inverse_layer_size, 0.0).rgb;
            left = 0u;
        }
    }
    if (left != 0u)
        added = added_by_panes(left);
    out_added = vec4(added, 1.0);
}
