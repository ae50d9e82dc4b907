// The lights of a scene, suns first, then points, then spots. World space is eye-centred: see
// frame_params.h.
#pragma once
#include "shared/bindings.h"
#include "shared/types.h"
FUM_SHARED_BEGIN

struct LightParams {
    vec4 position;  // xyz: metres; for a sun the unit direction to it; w: index of its first shadow
                    // view
    vec4 intensity;  // rgb: W/m^2 facing a sun, W/sr of a point or a spot
    vec4 axis;       // a spot's: xyz where it shines, unit length; w: cosine of its half cone
    vec4 edge;       // x: a spot's: 1 / width of its fading edge, in cosine; y: a point's: half a
                     // shadow view's width over that of a right angle
};

// One layer of the shadow map. Depth is linear: along the axis of a sun, the distance of a point or
// a spot, over range.
struct ShadowView {
    mat4 clip_from_world;
    vec4 origin;  // xyz: metres, where depth is 0; w: 1 / range [1/m]
    vec4 axis;    // xyz: a sun's direction of travel, or 0 where depth is a distance; w: bias [m]
                  // (per m of distance where axis is 0)
};

struct LightsParams {
    LightParams lights[MAX_LIGHTS];
    ShadowView views[MAX_SHADOW_VIEWS];
    vec4 world_radiance;  // rgb: mean over all directions [W/m^2/sr]
};

FUM_SHARED_END
