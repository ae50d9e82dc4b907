// Depth maps along directions to the sky, by which it is told how much of what a way stands for
// surfaces hide: see src/light/sky_share.h. World space is eye-centred: see frame_params.h.
#ifdef __cplusplus
#pragma once
#endif
#include "shared/types.h"
FUM_SHARED_BEGIN

#define SKY_MAPS 16  // of a way, drawn at once: tiles of one texture
#define SKY_MAPS_A_ROW 4
#define SKY_SHARES 254   // parts that a share is told in
#define SKY_UNKNOWN 255  // instead of a share: the node lies where the maps don't reach

// A point times 1 with these is its place in the tile, 0..1, and its way to the light, 0..1.
struct FUM_STD140 SkyMap {
    vec4 across, up, toward;
};

struct FUM_STD140 SkyMapParams {
    SkyMap maps[SKY_MAPS];
    vec3 low;    // nodes: of the box that the maps cover
    int way;     // that they are of, among all
    vec3 high;   // likewise
    int texels;  // along a tile's edge
};

FUM_SHARED_END
