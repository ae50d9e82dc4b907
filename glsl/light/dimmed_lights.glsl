// How the media dim lights, before there is a frame.
#include "scene/light_volumes.glsl"
#include "light/trace.glsl"

// Variant
const bool kMarched = false;  // there is an extinction's volume
const bool kDims = false;     // the media dim lights

vec3 depth_at(int i, vec3 p, LightSample light)
{
    const int kIslandSteps = 32;  // through each
    if (kDepthVolume)
        return vec3(depth_to_light(i, p, light));
    if (kIslands)  // the extinction's volume has one of them alone, and the others throw shadows too
        return vec3(optical_depth(p, light.wi, light.range, kIslandSteps));
    vec3 tau = vec3(closed_depth(p, light.wi, light.range));
    if (kMarched)
        tau += vec3(from_volume(traced_depth(p, light.wi, light.range, 1.0)));
    return tau;
}

vec3 through_media(int i, vec3 p, LightSample light) { return kDims ? exp(-depth_at(i, p, light)) : vec3(1.0); }
