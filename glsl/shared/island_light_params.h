// Volumes of the world's light of media whose parts lie far apart: see src/light/island_light.h.
// World space is eye-centred: see frame_params.h.
#pragma once
#include "shared/bindings.h"
#include "shared/types.h"
FUM_SHARED_BEGIN

// Where one part has its nodes, in the texture that all share.
struct FUM_STD140 IslandLattice {
    mat4 node_from_world;  // nodes from metres
    vec3 last;             // the last node along each axis
    float first;           // texel along z of the first one; below 0: no light gets there
};

struct FUM_STD140 IslandLightParams {
    IslandLattice lattices[MAX_ISLANDS + 1];  // the last that counts: of all parts together
    vec3 inverse_size;                        // 1 / texels of the texture
    int count;
};

FUM_SHARED_END
