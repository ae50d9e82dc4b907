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
    int unused_1;
    int unused_2;
    SunColumns filled;            // the sun's whose layer is filled
    SunColumns suns[MAX_LIGHTS];  // each sun's
};

FUM_SHARED_END
