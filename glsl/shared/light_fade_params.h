// Light that fades from what was filled before to what is filled now: see src/light/light_fade.h.
#pragma once
#include "shared/bindings.h"
#include "shared/types.h"
FUM_SHARED_BEGIN

struct FUM_STD140 LightFadeParams {
    mat4 before_from_node;  // nodes of the lattice before, from those of the lattice now
    vec3 last_before;       // the last node of that, along each axis
    float share;            // of the light now
    vec3 inverse_size;      // 1 / texels of its texture
    int layers;             // that both textures have along z
};

FUM_SHARED_END
