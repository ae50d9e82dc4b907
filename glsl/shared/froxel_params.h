// The froxel grid of a frame: what of the view each froxel holds, and how last frame's grid lay.
// World space is eye-centred: see frame_params.h.
#pragma once
#include "shared/types.h"
FUM_SHARED_BEGIN

// How slices are spaced along view depth: lib/froxel.glsl.
#define SLICES_LINEAR 0
#define SLICES_EXPONENTIAL 1
#define SLICES_POWER 2

struct FUM_STD140 SliceParams {
    float begin;        // view_z [m] where the first slice begins
    float end;          // and where the last one ends
    float depth;        // end - begin [m]
    float count;        // of slices
    int spacing;        // SLICES_*
    float rate;         // of an exponential spacing; of a power, the power
    float exp2_rate_1;  // exp2(rate) - 1
    float rescale;      // of last frame's: this frame's depth over its own
};

// Coefficients and sources are kept per slices.depth metres of ray and not per metre: a scene in
// millimetres keeps the same numbers as one in kilometres, and 16 bits hold both.
struct FUM_STD140 FroxelParams {
    SliceParams slices;
    vec2 columns;          // of froxels along x and y
    float tile_pixels;     // along a tile's edge
    float guard_columns;   // beyond the picture on each side
    vec3 jitter;           // where in its froxel a sample lies, 0..1
    float history_weight;  // 0..1
    mat4 clip_from_world;
    vec4 view_z_from_world;  // view_z of p = dot(vec4(p, 1), this)
    // The same of last frame, from this frame's world.
    SliceParams history_slices;
    mat4 history_clip_from_world;
    vec4 history_view_z_from_world;
    vec4 history_eye;       // xyz: where the eye was [m]; w 0: orthographic, the direction to it
    vec3 extinction_color;  // of all media, its brightest channel 1: scene/froxel_extinction.glsl
    uint dithered_frame;    // number of frames since the first of this history
};

FUM_SHARED_END
