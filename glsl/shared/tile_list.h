// The tiles that a compute pass takes, as its dispatch and its invocations find them: ahead of the
// tiles of each class, long ones first, that begin at even distances in the same buffer.
#pragma once
#include "shared/types.h"
FUM_SHARED_BEGIN

#define TILE_CLASSES 4  // by how many splits of the march a tile has
#define TILE_GROUP 64   // texels, or pixels, that a work group takes
#define TILE_ROW 16u    // groups of a dispatch side by side: GL promises 65535 of them and no more

struct TileListHead {
    uint groups_x, groups_y, groups_z;  // of the dispatch
    uint groups;                        // that have tiles, those beyond TILE_ROW too
    uint tiles[TILE_CLASSES];           // of each class
};

// Groups that so many tiles of so many texels each take.
FUM_SHARED_FUNCTION uint tile_groups(uint tiles, uint texels)
{
    return (tiles * texels + uint(TILE_GROUP) - 1u) / uint(TILE_GROUP);
}

// A tile's place among all of them, in 16 bits each way.
FUM_SHARED_FUNCTION uint tile_word(ivec2 tile)
{
    return uint(tile.x) | uint(tile.y) << 16u;
}
FUM_SHARED_FUNCTION ivec2 tile_at(uint word)
{
    return ivec2(int(word & 0xffffu), int(word >> 16u));
}

FUM_SHARED_END
