// The tiles that hold something, for compute passes over them: those that take long first, so that none of them is
// left to run alone at the end.
//   in   a texel a tile, as StepSlots::tile() of src/pass/step_slots.h makes it; a list with nothing in it
//   out  the list, and the size of the dispatch over it
#include "scene/frame.glsl"
#include "shared/step_tile.h"
#include "shared/tile_list.h"

// Variant, as in pass/tiles.vert
const int kTilePixels = 1;
const bool kAllTiles = true;
const bool kLitTiles = true;
const bool kByDistance = false;
const bool kFarTiles = false;

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = STEP_TILES_UNIT) uniform usampler2D u_tiles_tx;
layout(std430, binding = TILE_LIST_BUFFER) buffer TileList
{
    TileListHead u_list;
    uint u_listed_tiles[];
};

// The lanes of this group that list a tile, a bit each: the list's own counters are asked once a group, and its tiles keep
// their order whichever lane is first.
shared uint s_lanes[TILE_CLASSES][2];
shared uint s_first[TILE_CLASSES];

// Morton's order. Four tiles make up a group of a pass over the list, whose lanes take as long as the longest ray among
// them: a square of neighbours has rays that are most alike.
uvec2 tile_of_lane(uint lane)
{
    return uvec2(lane & 1u | lane >> 1 & 2u | lane >> 2 & 4u, lane >> 1 & 1u | lane >> 2 & 2u | lane >> 3 & 4u);
}

uint tiles_of_class(uint k) { return uint(bitCount(s_lanes[k][0]) + bitCount(s_lanes[k][1])); }

// Tiles of a class that lanes before this one list.
uint place_in_class(uint k, uint lane)
{
    uint before = (1u << (lane & 31u)) - 1u;
    return uint(lane < 32u ? bitCount(s_lanes[k][0] & before)
                           : bitCount(s_lanes[k][0]) + bitCount(s_lanes[k][1] & before));
}

// By the march's steps in it, of those of a ray from end to end: a half, a quarter, an eighth.
uint class_of(uvec4 tile)
{
    int ones = bitCount(tile.x & ~(tile.y | tile.z));
    int quarters = (4 * ones + 2 * bitCount(tile.x & tile.z) + bitCount(tile.x & tile.y)) << tile_log2_width(tile.w);
    int share = 4 * int(u_frame.steps) / max(quarters, 1);
    return share < 2 ? 0u : share < 4 ? 1u : share < 8 ? 2u : 3u;
}

// Has the dispatch, in rows of TILE_ROW, reach so many groups more.
void dispatch_more(uint groups)
{
    uint before = atomicAdd(u_list.groups, groups);
    uint rows = (before + groups + TILE_ROW - 1u) / TILE_ROW - (before + TILE_ROW - 1u) / TILE_ROW;
    if (rows > 0u)
        atomicAdd(u_list.groups_y, rows);
}

void main()
{
    uint lane = gl_LocalInvocationIndex;
    if (lane < TILE_CLASSES)
        s_lanes[lane] = uint[2](0u, 0u);
    barrier();
    ivec2 at = ivec2(gl_WorkGroupID.xy * gl_WorkGroupSize.xy + tile_of_lane(lane));
    uvec4 tile = uvec4(0u);
    if (all(lessThan(at, textureSize(u_tiles_tx, 0))))
        tile = texelFetch(u_tiles_tx, at, 0);
    bool listed = tile.x != 0u && (kAllTiles || tile_is_lit(tile.w) == kLitTiles) &&
                  (!kByDistance || tile_is_far(tile.w) == kFarTiles);
    uint of_class = class_of(tile);
    if (listed)
        atomicOr(s_lanes[of_class][lane >> 5], 1u << (lane & 31u));
    barrier();
    uint count = lane < TILE_CLASSES ? tiles_of_class(lane) : 0u;
    if (count > 0u) {
        const uint kTexels = uint(kTilePixels * kTilePixels);
        uint first = atomicAdd(u_list.tiles[lane], count);
        dispatch_more(tile_groups(first + count, kTexels) - tile_groups(first, kTexels));
        s_first[lane] = first;
    }
    barrier();
    if (listed)
        u_listed_tiles[of_class * (uint(u_listed_tiles.length()) / TILE_CLASSES) + s_first[of_class] +
                       place_in_class(of_class, lane)] = tile_word(at);
}
