// What an inspection draws and in which colours. World space is eye-centred: see frame_params.h.
#pragma once
#include "shared/types.h"
FUM_SHARED_BEGIN

struct InspectParams {
    mat4 clip_from_boxes;  // of the boxes that are drawn
    vec4 scale;       // x: value at the start of the colours; y: 1 / (end - start); z: slice of
                      // the froxels
    vec4 plane;       // xyz: the axis it is normal to, 1 there; w: its place along it [m]
    vec4 bounds_min;  // xyz: of all media [m]
    vec4 bounds_max;  // xyz
};

FUM_SHARED_END
