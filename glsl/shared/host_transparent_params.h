// What a host's own transparents need to know of a frame: glsl/host/transparent.glsl.
#pragma once
#include "shared/types.h"
FUM_SHARED_BEGIN

struct FUM_STD140 HostTransparentParams {
    vec4 view_z_from_depth;  // as in frame_params.h
    // view_z [m] = view_z_per_w / gl_FragCoord.w + view_z_at_w of a perspective camera.
    float view_z_per_w;  // 0: orthographic
    float view_z_at_w;
    float sky_depth;       // as in frame_params.h
    float radiance_limit;  // likewise
    uint first_draw;       // among all of the picture's: the scene's own come before
    uint half_color;       // not 0: colours have 16 bits a channel
    int unused_x, unused_y;
};

FUM_SHARED_END
