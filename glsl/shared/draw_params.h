// One surface in one draw, into the picture or into a shadow view.
#pragma once
#include "shared/types.h"
FUM_SHARED_BEGIN

struct DrawParams {
    mat4 clip_from_object;
    mat4 world_from_object;  // eye-centred metres (light-centred in a shadow view)
    vec4 albedo;             // rgb
    vec4 shadow_origin;      // as ShadowView::origin, light-centred
    vec4 shadow_axis;        // as ShadowView::axis
};

FUM_SHARED_END
