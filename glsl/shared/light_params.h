// The lights of a scene, in the order of Light's types, as the points that stand for each: one of a
// sun, a point or a spot. World space is eye-centred: see frame_params.h.
#pragma once
#include "shared/bindings.h"
#include "shared/types.h"
FUM_SHARED_BEGIN

struct FUM_STD140 LightParams {
    vec3 position;          // metres; for a sun the unit direction to it
    float first_view;       // index of its first shadow view
    vec3 intensity;         // W/m^2 facing a sun, else W/sr; of a spot on its axis
    float cube_view_scale;  // of one that shines all around: half a shadow view's width over that
                            // of a right angle
    vec4 own[4];            // what lights of its type have besides: a SpotParams
};

// A spot's own, in this order.
struct FUM_STD140 SpotParams {
    vec3 axis;  // where it shines, unit length
    float cos_half_cone;
    float inverse_edge_width;  // 1 / width of its fading edge, in cosine
};

// The depth that a shadow view keeps, linear in metres: lib/shadow.glsl.
struct FUM_STD140 ShadowDepth {
    vec3 origin;          // metres, where depth is 0
    float inverse_range;  // [1/m]
    vec3 travel;  // a sun's direction of travel, or 0 where depth is the distance from origin
    float bias;   // [m], or metres per metre of distance
};

// One layer of the shadow map.
struct FUM_STD140 ShadowView {
    mat4 clip_from_world;
    ShadowDepth depth;
};

struct FUM_STD140 LightsParams {
    LightParams lights[MAX_LIGHT_POINTS];
    ShadowView views[MAX_SHADOW_VIEWS];
    vec4 world_radiance;  // rgb: mean over all directions [W/m^2/sr]
};

FUM_SHARED_END
