// Which texel an invocation of a compute pass over listed tiles (pass/list_tiles.comp) works on.
#include "shared/tile_list.h"
#include "shared/bindings.h"

// Variant
const int kTilePixels = 1;  // along a tile's edge: 4 or 16

layout(local_size_x = TILE_GROUP) in;
layout(std430, binding = TILE_LIST_BUFFER) readonly buffer TileList
{
    TileListHead u_list;
    uint u_listed_tiles[];
};

struct ListedTexel {
    bool is_there;  // or the invocation is one too many
    ivec2 tile, texel;
};

// A group has four tiles of 4x4, or a quarter of one of 16x16: 8x8 where tiles are neighbours.
ListedTexel listed_texel(ivec2 size)
{
    const uint kTexels = uint(kTilePixels * kTilePixels);
    uint capacity = uint(u_listed_tiles.length()) / TILE_CLASSES;
    uint group = gl_WorkGroupID.y * TILE_ROW + gl_WorkGroupID.x;
    for (uint k = 0u; k < TILE_CLASSES; ++k) {
        uint count = u_list.tiles[k];
        uint groups = tile_groups(count, kTexels);
        if (group >= groups) {
            group -= groups;
            continue;
        }
        uint i = group * TILE_GROUP + gl_LocalInvocationIndex;
        if (i >= count * kTexels)
            break;
        ivec2 tile = tile_at(u_listed_tiles[k * capacity + i / kTexels]);
        i %= kTexels;
        uvec2 texel =
            kTilePixels == 4 ? uvec2(i & 3u, i >> 2) : uvec2(i & 7u, i >> 3 & 7u) + 8u * uvec2(i >> 6 & 1u, i >> 7);
        ivec2 at = tile * kTilePixels + ivec2(texel);
        return ListedTexel(all(lessThan(at, size)), tile, at);
    }
    return ListedTexel(false, ivec2(0), ivec2(0));
}
