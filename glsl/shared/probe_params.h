// A probe's light in a layer of a texture: octahedral maps, the first as it was captured and each
// other one as GGX of an alpha reflects it, and nine texels of harmonics. Every map has a border of
// a texel, by which it is filtered across its edges.
#pragma once
#include "shared/bindings.h"
#include "shared/types.h"
FUM_SHARED_BEGIN

#ifndef __cplusplus
const int kProbeHarmonics = 9;  // of bands 0 to 2
#endif

// One of its maps, or of the pyramid of means that they are filtered from.
struct FUM_STD140 ProbeMap {
    ivec2 first;  // texel, the border left out
    int size;     // texels along its edge
    int layer;
};

struct FUM_STD140 ProbeFilterParams {
    ProbeMap from, to;
    float alpha;  // of the GGX that a map is filtered by
};

// Where a lookup finds the maps of a layer.
struct FUM_STD140 ProbeLayoutParams {
    vec4 maps[PROBE_MAPS];  // first and size [texture coordinates]
    float last;  // index of the roughest, whose alpha is 1; half that of it one before, and so on
    int harmonics;  // their row of texels
};

// How a probe's directions are turned to where it is looked up: LightProbe::Parallax.
const int kParallaxSphere = 1;
const int kParallaxBox = 2;

struct FUM_STD140 PlacedProbe {
    vec3 position;  // metres
    float radius;   // [m], beyond which it has no weight
    vec3 box_min;   // metres
    float edge;     // [m] within that, over which its weight grows
    vec3 box_max;   // metres
    int parallax;
    vec3 seen_from;      // metres: where it was when layer was captured
    int layer;           // of what it has seen last
    vec3 old_seen_from;  // likewise
    int old_layer;       // and before that
    float newness;       // how much of the former
    float weight;        // the most that it has
    float fog;           // [1/m]: extinction of even media that it stands in
    float fog_albedo;    // 0..1
};

struct FUM_STD140 ProbesParams {
    ProbeLayoutParams world, placed;
    PlacedProbe probes[MAX_PROBES];  // those that are ready
    int count;
};

FUM_SHARED_END
