// A transparent: positions of its mesh to clip space, with their view depth.
#include "scene/frame.glsl"
#include "scene/split_depths.glsl"
#include "shared/bindings.h"
#include "shared/transparent_params.h"

// Variant
const bool kOver = false;  // over a picture in order: it lies where src/transparent/media_mask.h has what is drawn

layout(std140, binding = TRANSPARENT_BLOCK) uniform Transparent { TransparentParams u_transparent; };
layout(location = 0) in vec3 in_position;  // of a quad or a billboard 0..1, its lower left at 0
out float view_z;                          // metres
out vec2 uv;
#define OVER_VARYING out
#include "scene/over_varying.glsl"

void main()
{
    vec4 p = vec4(in_position, 1.0);
    view_z = dot(u_transparent.view_z_from_object, p);
    uv = in_position.xy;
    gl_Position = u_transparent.clip_from_object * p;
    if (!kOver)
        return;
    gl_Position.z = 0.0;
    over_depths = u_frame.view_z_from_depth;
    over_limits = vec3(u_frame.media_range.y, u_frame.sky_depth, u_frame.radiance_limit);
    over_layer = vec4(u_frame.layer_offset, u_frame.inverse_layer_size);
    over_sizes = vec4(u_frame.inverse_full_size, u_frame.layer_size);
    over_view_z = u_transparent.view_z;
    over_source = u_transparent.source;
    over_of_source = u_transparent.of_source;
    over_of_behind = u_transparent.of_behind;
    over_faded = u_transparent.faded;
    over_fades = u_transparent.fades;
    over_inverse_depth_fade = u_transparent.inverse_depth_fade;
    over_pane = u_transparent.pane;
    if (kSplitFours > 4)
        return;
    for (int i = 0; i < kSplitFours; ++i)
        over_splits[i] = u_splits.view_z[i];
    over_split_count = u_splits.count;
}
