// The upsample by fragments: resolve/upsample.glsl.
#define FRAME_VARYING in
#include "scene/frame_varying.glsl"
#include "shared/frame_params.h"
FrameParams g_frame;  // what the upsample needs of it
#define u_frame g_frame
#include "resolve/upsample.glsl"

Resolved resolve_pixel(ivec2 pixel)
{
    g_frame.view_z_from_depth = frame_depths;
    g_frame.media_range = frame_limits.xy;
    g_frame.sky_depth = frame_limits.z;
    g_frame.depth_threshold = frame_limits.w;
    g_frame.layer_offset = frame_layer.xy;
    g_frame.media_depth = frame_layer.z;
    return upsampled(pixel);
}

#include "resolve/blended.glsl"
