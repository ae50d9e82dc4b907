// One surface in one draw, into the picture or into a shadow view.
#pragma once
#include "shared/light_params.h"
#include "shared/types.h"
FUM_SHARED_BEGIN

struct FUM_STD140 DrawParams {
    mat4 clip_from_object;
    mat4 world_from_object;  // eye-centred metres (light-centred in a shadow view)
    vec3 albedo;
    float roughness;
    vec3 emission;  // [W/m^2/sr]
    float metallic;
    ShadowDepth shadow_depth;  // light-centred
    int number;                // of the surface, in the scene
    int is_open;               // 1: a sheet, whose back is seen as its front is
};

FUM_SHARED_END
