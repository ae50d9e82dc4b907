// What an inspection draws and in which colours. World space is eye-centred: see frame_params.h.
#pragma once
#include "shared/types.h"
FUM_SHARED_BEGIN

struct FUM_STD140 InspectParams {
    mat4 clip_from_boxes;       // of the boxes that are drawn
    vec3 plane_axis;            // that the plane is normal to: 1 there, else 0
    float plane_place;          // where along it the plane is [m]
    vec3 bounds_min;            // of all media [m]
    float scale_begin;          // value at the start of the colours
    vec3 bounds_max;            // [m]
    float inverse_scale_width;  // 1 / (end - start)
    int slice;                  // of the froxels
};

FUM_SHARED_END
