// Panes of one colour each that are in order: flat parallelograms, the nearest first.
#pragma once
#include "shared/types.h"
FUM_SHARED_BEGIN

#define MAX_PANES                                                                                  \
    8  // so that what they are at a pixel is within what OpenGL promises to interpolate

struct FUM_STD140 PaneParams {
    // Where a pixel's ray meets a pane's plane, affine in NDC x, y: centre + x * dx + y * dy.
    // Homogeneous: x and y over w are 0..1 along its edges, z over w is view_z [m].
    vec4 at[MAX_PANES];
    vec4 at_dx[MAX_PANES];
    vec4 at_dy[MAX_PANES];
    vec4 emitted[MAX_PANES];  // the source times its factor of blending; rgb alone
    vec4 kept[MAX_PANES];     // the factor of what is behind; rgb alone
    vec2 view_z;              // the near and the far plane's [m]
    int count;
    int unused;
};

FUM_SHARED_END
