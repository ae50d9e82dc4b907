// What a host's own shaders look the media up with: glsl/host/volume_at.glsl.
#pragma once
#include "shared/frame_params.h"
#include "shared/froxel_params.h"
#include "shared/split_params.h"
#include "shared/types.h"
FUM_SHARED_BEGIN

#define VOLUME_AT_NOTHING 0  // no medium is in view
#define VOLUME_AT_FROXELS 1
#define VOLUME_AT_SPLITS 2

// Transmittance in a texture of its own; in the scattering's alpha; its red there, the rest in a
// texture of two channels.
#define VOLUME_AT_APART 0
#define VOLUME_AT_GREY 1
#define VOLUME_AT_RED_IN_ALPHA 2

struct FUM_STD140 VolumeAtParams {
    FrameParams frame;
    FroxelParams froxels;  // VOLUME_AT_FROXELS
    SplitParams splits;    // VOLUME_AT_SPLITS
    int kind;              // VOLUME_AT_*
    int layer_scale;       // pixels along the edge of a texel of the march's layer
    int transmittance;     // VOLUME_AT_APART ... where it is
    int tricubic;          // not 0: froxels are looked up by a B-spline
};

FUM_SHARED_END
