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

struct FUM_STD140 LightVolumesParams {
    LatticeParams extinction;  // of the marched media: there while the others are filled
    LatticeParams depth;       // a layer a light
    LatticeParams world;
    LatticeParams surfaces;  // of the world's light that reaches surfaces
    vec4 extinction_color;   // what one stored number stands for: rgb: a colour; a: 1
    vec3 view_axis;          // where an orthographic eye looks, unit length
    float orthographic;      // 1, else 0
    vec3 light;              // of the layer that is filled: the direction to a sun, or a place [m]
    float light_has_place;   // 1, or 0 of a sun
    int layer;               // that is filled
    int first_slice;         // of nodes along z that is filled
    int samples;             // of the media along an edge of a node's cell
    int unused;
};

FUM_SHARED_END
