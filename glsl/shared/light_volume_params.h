// Volumes of light that are kept while lights, media and surfaces stay: see
// src/light/light_volumes.h. World space is eye-centred: see frame_params.h.
#pragma once
#include "shared/bindings.h"
#include "shared/light_params.h"
#include "shared/types.h"
FUM_SHARED_BEGIN

// A box of nodes whose outermost ones lie on its faces; its axes may be sheared as a grid's are.
struct LatticeParams {
    mat4 node_from_world;  // nodes from metres
    mat4 world_from_node;
    vec4 last;  // xyz: the last node along each axis; w: layers that the texture has along z
    vec4 inverse_size;  // xyz: 1 / texels of the texture; w: metres from node to node along x
};

struct LightVolumesParams {
    LatticeParams extinction;  // of the marched media: there while the others are filled
    LatticeParams depth;       // a layer a light
    LatticeParams world;
    LatticeParams surfaces;  // of the world's light that reaches surfaces
    vec4 extinction_color;   // what one stored number stands for: rgb: a colour; a: 1
    vec4 view;               // xyz: where an orthographic eye looks, unit length; w: 1, else all 0
    vec4 fill;   // x: the layer that is filled; y: directions of the world; z: media samples along
                 // an edge of a node's cell; w: the first node along z
    vec4 light;  // of that layer: xyz: the direction to a sun, w: 0; or a place [m], w: 1
};

// Light of the world from the directions of one cell of the sphere.
struct WorldDirection {
    vec4 wi;     // xyz: to where it comes from, unit length
    vec4 power;  // rgb: radiance times the cell's solid angle [W/m^2]
};

struct WorldParams {
    WorldDirection directions[MAX_WORLD_DIRECTIONS];
    ShadowView views[MAX_WORLD_DIRECTIONS];
};

FUM_SHARED_END
