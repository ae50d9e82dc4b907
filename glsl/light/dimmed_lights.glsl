// How the media dim lights, before there is a frame.
#include "scene/light_volumes.glsl"
#include "light/trace.glsl"

// Variant
const bool kMarched = false;  // there is an extinction's volume
const bool kDims = false;     // the media dim lights

vec3 marched_at(int i, vec3 p, LightSample light)
{
    const int kIslandSteps = 32;  // through each
    if (kDepthVolume)
        return vec3(marched_to_light(i, p, light));
    if (kIslands)  // the extinction's volume has one of them alone, and the others throw shadows too
        return vec3(marched_depth(p, light.wi, light.range, kIslandSteps));
    return kMarched ? vec3(from_volume(traced_depth(p, light.wi, light.range, 1.0))) : vec3(0.0);
}

vec3 through_media(int i, vec3 p, LightSample light)
{
    if (!kDims)
        return vec3(1.0);
    return exp(-(vec3(closed_depth(p, light.wi, light.range)) + marched_at(i, p, light)));
}

// The optical depth that dims a light which the media scatter at p.
vec3 dimming_at(int i, vec3 p, LightSample light)
{
    return vec3(closed_dimming(p, light.wi, light.range)) + u_media.marched_light_dimming * marched_at(i, p, light);
}
