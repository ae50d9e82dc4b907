// Light that is carried through a lattice of cubes, along ways that lead from node to node: see
// src/light/radiance_field.h. World space is eye-centred: see frame_params.h.
#ifdef __cplusplus
#pragma once
#endif
#include "shared/light_volume_params.h"
#include "shared/types.h"
FUM_SHARED_BEGIN

#define FIELD_BATCH 74         // ways that are walked at once
#define FIELD_WAYS_A_ROW 4     // beside each other in an image of them
#define FIELD_WAYS_BESIDE 4    // as surfaces are drawn along their lines
#define WALL_STEPS 65535       // of the way from a node to the next that surfaces are told apart by
#define FIELD_CROSSED_WORDS 3  // of 32 ways each that surfaces cross
#define FACE_PARTS 4           // along each edge of what a face stands for
#define CLEARANCE_MOST 8       // nodes without a surface that are told of
#define FIELD_FARTHER 2        // nodes beyond a hole's faces at which what lies in it takes light
#define FIELD_MOST_ORDERS 64   // of scattering
#define FIELD_KEPT_ORDERS 8    // that the rest is guessed from
#define FIELD_TAKEN 16         // numbers of a node by light/field_taken.comp, in whole texels
#define FIELD_TAKEN_OF_CELL 13  // which of them is that of its own cell

// A direction that light is carried along, from slice to slice of nodes across an axis. In a
// lattice of cubes the step from a node leads to another along most ways, elsewhere to the node
// that is nearest.
struct FUM_STD140 FieldWay {
    vec3 entry;         // the world's radiance that comes along [W/m^2/sr]
    int axis;           // of the slices: 0: x
    vec3 wi;            // to where light comes from, unit length
    float metres;       // from a slice to the next
    vec2 slope;         // nodes across, along the next two axes in turn, from a slice to the next
    float forward;      // 1 where light goes up along the axis, else -1
    float solid_angle;  // that it stands for [sr]
    ivec2 first_line;   // across slice 0, of those that surfaces are drawn along
    int beside;  // of all ways those that come from lower and from higher along the next axis, and
                 // along the one after it: four times eight bits, for a way that is along neither
};

struct FUM_STD140 FieldParams {
    LatticeParams nodes;
    LatticeParams other;  // whose light this one takes over
    FieldWay ways[FIELD_BATCH];
    vec3 albedo;      // of places that have no medium
    int count;        // of the ways
    vec3 media_low;   // nodes: of a box that holds all media
    int first;        // of the ways among all
    vec3 media_high;  // likewise
    int order;        // of scattering that is summed up: 0 the lights' and the world's own light
    vec3 ends_low;  // nodes: faces that media end at, with all of their density; far off: none does
    float in_plane;     // part of the sphere that the ways in a plane of the axes stand for
    vec3 ends_high;     // likewise
    int slot;           // of the order that is kept, among those that the rest is guessed from
    ivec2 lines;        // that surfaces are drawn along, across, of ways beside each other: pixels
    float tilt;         // of them: nodes across a slice, about where they cross the middle one
    int slots;          // of orders that are kept
    float straight_on;  // share of the extinction that is scattered straight on: taken for none
    int apart;          // pixels from the first line of a way to that of the next beside it
    ivec2 left_out;     // points that are no lights here: the first, and the one after the last
    vec3 hole_low;      // nodes: of a box whose light is told elsewhere
    float unused_1;
    vec3 hole_high;
    float unused_2;
};

FUM_SHARED_END
