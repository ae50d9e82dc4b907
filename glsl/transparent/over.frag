// Lays one of the scene's transparents over the picture, which has the media, the surfaces and all transparents behind
// it already: what transparent/resolve.frag does with lists, where none is needed to tell the order.
//   in   scene/transparent_fragment.glsl; what the media do before any depth
//   out  what the picture is multiplied with, the second source of blending, and what is added to it
#include "lib/blend.glsl"
#include "scene/frame.glsl"
#include "scene/split_depths.glsl"
#define OVER_VARYING in
#include "scene/over_varying.glsl"
FrameParams g_frame;  // what is needed of it
SplitParams g_splits;

void take_varyings()
{
    g_frame.view_z_from_depth = over_depths;
    g_frame.media_range = vec2(0.0, over_limits.x);
    g_frame.sky_depth = over_limits.y;
    g_frame.radiance_limit = over_limits.z;
    g_frame.layer_offset = over_layer.xy;
    g_frame.inverse_layer_size = over_layer.zw;
    g_frame.inverse_full_size = over_sizes.xy;
    g_frame.layer_size = over_sizes.zw;
    if (kSplitFours > 4) {
        g_splits = u_splits;
        return;
    }
    for (int i = 0; i < kSplitFours; ++i)
        g_splits.view_z[i] = over_splits[i];
    g_splits.count = over_split_count;
}

#define u_frame g_frame
#define u_splits g_splits
#define LOOK(member) over_##member
#include "scene/transparent_fragment.glsl"
#include "written/volume_at.glsl"

// Variant
const bool kKeptAtPanes = false;  // a march kept what it met where its rays meet the planes of panes in order
const float kOfBehind = 0.0;      // what the color behind weighs in the source's factor
const int kCutFours = 0;  // along how many lines it is cut off, where others go through it, by fours; 0: it is whole

layout(early_fragment_tests) in;  // src/transparent/media_mask.h
layout(location = 0, index = 0) out vec4 out_added;
layout(location = 0, index = 1) out vec4 out_kept;

// Of two pieces on both sides of a line each pixel has one, as both work out the same of it.
bool is_cut_off()
{
    vec2 ndc = gl_FragCoord.xy * u_frame.inverse_full_size * 2.0 - 1.0;
    int signs = 0;
    for (int i = 0; i < kCutFours; ++i) {
        precise vec4 at = ndc.x * u_transparent.cut_dx[i] + ndc.y * u_transparent.cut_dy[i] + u_transparent.cut[i];
        ivec4 sides = floatBitsToInt(at) ^ u_transparent.cut_sign[i];
        signs |= sides.x | sides.y | sides.z | sides.w;
    }
    return signs < 0;
}

void main()
{
    take_varyings();
    float scene_z = scene_view_z();
    // Its depth on the screen is the mask's, so that nothing else clips it.
    bool seen = view_z < scene_z && view_z >= over_view_z.x && view_z <= over_view_z.y;
    if (!seen || is_cut_off())
        discard;
    vec4 source = transparent_source(scene_z);
    VolumeRay ray = volume_ray(gl_FragCoord.xy);
    VolumeAt at;
    if (kKeptAtPanes)
        at = volume_at_pane(ray, over_pane, view_z);
    else
        at = volume_at(ray, view_z);
    vec3 kept = own_factor(over_of_behind, source);
    if (kOfBehind != 0.0)  // which is so much more of what is behind
        kept += kOfBehind * source.rgb * at_depth(at.transmittance, at.transmittance);
    out_added = vec4(added_in_volume(at, source.rgb * own_factor(over_of_source, source), kept), 1.0);
    out_kept = vec4(kept, 1.0);
}
