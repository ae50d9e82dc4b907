// Volumes of light that are kept while lights, media and surfaces stay: see
// src/light/light_volumes.h. World space is eye-centred: see frame_params.h.
#pragma once
#include "shared/bindings.h"
#include "shared/light_params.h"
#include "shared/types.h"
FUM_SHARED_BEGIN

// A box of nodes whose outermost ones lie on its faces; its axes may be sheared as a grid's are.
struct FUM_STD140 LatticeParams {
    mat4 node_from_world;  // nodes from metres
    mat4 world_from_node;
    vec3 last;          // the last node along each axis
    float layers;       // that the texture has along z
    vec3 inverse_size;  // 1 / texels of the texture
    float spacing;      // metres from node to node along x
};

// How a sun's nodes stand in the volume of depths: plane n of nodes along one axis of the lattice
// is the lattice's own, moved by n times the shear, so that a column of them runs along the sun's
// light.
struct FUM_STD140 SunColumns {
    vec3 shear;   // nodes a plane; 0 along the axis
    int axis;     // along which the light goes most
    vec3 normal;  // 1 along it, else 0
    int to_last;  // 1 if the sun is at the axis' end, else 0
};

// A point in them: along each axis of the lattice in periods of the columns, the one along which
// they run with its plane of nodes, and so where it is in the volume, whichever period it is in.
struct FUM_STD140 SunLookup {
    mat4 column_from_world;  // w: planes, in periods, that grow towards the sun
    // Along each axis: the plane where a column comes into the lattice's range is this times where
    // the column is, and added to `enters`.
    vec3 per_period;
    float first_z;  // of kPackedDepths
    vec3 enters;
    float unused_1;
    vec3 across;  // planes from there to where it leaves that range
    float unused_2;
    vec3 towards;  // what a plane adds to a place in periods
    float unused_3;
    vec3 first;  // texture coordinates of the first node of its layer
    float unused_4;
};

// What media glow, and what of it arrives at nodes that stand the farther apart the farther they
// are from it. Along each axis they are even over what glows, and beyond it their distance grows
// evenly.
struct FUM_STD140 FireParams {
    LatticeParams flame;       // while it is filled: over what glows
    LatticeParams media;       // and over all media
    vec4 points[FIRE_POINTS];  // [m]: that tell what surfaces hide of it; xyz
    vec3 middle;               // of the box that glows [m]
    float inverse_node;        // nodes a metre there
    vec3 core;                 // half its edges [m]
    float growth;              // metres beyond it within which nodes are twice as far apart
    vec3 first;                // the node that the middle is
    float is_seen;             // 1; 0: surfaces have none of it
    vec3 last;                 // node along each axis
    float rays;                // along the box's longest edge
    vec3 extinction_color;     // while it is filled: what one stored number stands for
    float unused;
};

// Of the edge of the volume for surfaces: in so much of it towards its faces its light becomes that
// beyond.
#define SURFACES_RIM 0.15f

struct FUM_STD140 LightVolumesParams {
    LatticeParams extinction;  // of the marched media: there while the others are filled
    LatticeParams depth;       // a layer a light; its texture has more than its nodes
    LatticeParams world;
    LatticeParams surfaces;  // of the world's light that reaches surfaces
    vec4 extinction_color;   // what one stored number stands for: rgb: a colour; a: 1
    vec3 view_axis;          // where an orthographic eye looks, unit length
    float orthographic;      // 1, else 0
    vec3 depth_period;       // nodes along each axis after which a sun's columns are there again
    float packed_scale;      // 1 / texels along z of the volume of packed depths
    vec3 light;              // of the layer that is filled: where its light is [m]
    int layer;               // that is filled
    int first_slice;  // of nodes along z, or of columns along their second axis, that is filled
    int samples;  // of the media along an edge of a node's cell, or from node to node of a column
    int first_flame;             // of the points that stand for the flames whose light `amid` has
    int beyond_flame;            // and the one after the last
    SunColumns filled;           // the sun's whose layer is filled
    vec3 period_size;            // of the columns, in texture coordinates
    float packed_period_z;       // of kPackedDepths
    SunLookup suns[MAX_LIGHTS];  // each sun's
    FireParams fire;
    LatticeParams amid;     // of the world's light, where what is marched lies amid wider media
    vec3 amid_per_low_rim;  // 1 / nodes, along each axis, from its lower faces on in which it takes
                            // over
    float unused_1;
    vec3 amid_per_high_rim;  // likewise of the upper ones
    float unused_2;
    vec3 media_middle;   // of a box that holds all of them [m]
    float media_radius;  // of a ball about as large [m]
};

FUM_SHARED_END
