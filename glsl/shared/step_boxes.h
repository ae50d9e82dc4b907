// What the media's boxes are projected to step tiles with, by compute shaders: all in doubles, so
// that the tiles are those that the CPU works out (src/pass/step_tiles.cpp).
#pragma once
#include "shared/bindings.h"
#include "shared/types.h"
FUM_SHARED_BEGIN

#define MAX_STEP_PARTS 48  // of the media: density, what it emits and a temperature of each
#define STEP_SLOTS 64      // of the step lattice: StepSlots of src/pass/step_slots.h
#define STEP_GROUP 64      // invocations that share a box's tiles

// A box that may hold a medium, in its part's space. By std430.
struct StepBox {
    dvec4 low;   // then the longest step in it [m]
    dvec4 high;  // then its largest extinction [1/m]
};

// What a tile of the march sees of all boxes; zeroes: nothing. By std430.
struct SeenTile {
    uint slots_low, slots_high;  // that hold something
    uint not_longest;            // complement of the bits of the longest step [m], a float: the
                                 // more the shorter
    uint most;                   // bits of the largest extinction [1/m], a float
};

// A light that has a place, beside the rays of a picture: src/pass/step_view.h.
struct StepLight {
    dvec2 pixel;
    double metres;  // of a pixel, where the light is
    double least;   // [m] of a light behind the eye
    double view_z;  // [m]
    double unused;
};

struct StepViewParams {
    dmat4 view_from_boxes[MAX_STEP_PARTS];
    dmat4 clip_from_view;
    dvec2 ends[STEP_SLOTS / 2 + 1];  // view_z [m] where slots begin, two in each
    dvec2 lengths[STEP_SLOTS / 2];   // of the slots' splits [m]
    StepLight lights[MAX_LIGHT_POINTS];
    dvec2 picture;          // pixels
    dvec2 offset;           // of the layer's first texel from the picture's, in texels
    double near;            // view_z [m]
    double scale;           // pixels of a texel
    double reach;           // of the layer's texels that a pixel is made of, those on either side
    double slack;           // texels, and pixels
    double depth_rounding;  // of view_z
    double shaft;           // optical depth of a step in which a shadow may end
    double far_share;       // of a light's distance that a step has which it is far from; 0: none
    double tile_radius;     // pixels from a tile's middle to its corner
    ivec4 parts[MAX_STEP_PARTS];  // first box, how many
    ivec2 march_tiles, picture_tiles;
    int slot_count, slot_width;
    int light_count;
    int spaced;           // whether steps are as long as the media let them be
    int lit;              // whether no surface hides a light from any tile
    int shafts_anywhere;  // whether a shadow may end in any step
    ivec2 unused_a;
    ivec4 unused_b;  // a block is a multiple of its doubles' columns
};

FUM_SHARED_END
