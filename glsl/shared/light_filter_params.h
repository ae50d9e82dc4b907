// What transparents that cast let through of the lights, and how it is drawn.
#pragma once
#include "shared/light_params.h"
#include "shared/types.h"
FUM_SHARED_BEGIN

// Of a light's point, by the numbers of LightsParams. World space is eye-centred.
struct FUM_STD140 LightFilterParams {
    mat4 clip_from_world;  // of a sun and of a spot
    ShadowDepth depth;
    float first_layer;      // of the map, of the nearest transparents
    float cube_view_scale;  // of one that shines all around, as LightParams has it
    float unused_a, unused_b;
};

struct FUM_STD140 LightFiltersParams {
    LightFilterParams points[MAX_LIGHT_POINTS];
};

// One transparent in one draw into a layer of the map. Object to the light's space.
struct FUM_STD140 LightFilterDrawParams {
    mat4 clip_from_object;
    mat4 light_from_object;  // light-centred metres
    ShadowDepth depth;       // light-centred
    vec4 source;             // as TransparentParams has it
    uint factor;             // of what is behind: transparent_params.h
    uint is_filter;          // as TransparentParams has it
    int layer_before;        // of those that are nearer
    float unused;
};

FUM_SHARED_END
