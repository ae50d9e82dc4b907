// A tile of the march in four times 32 bits: which splits of the step lattice are marched, and how
// long its steps are. Up to 31 slots of a power of two of splits each, a bit a slot:
//   x     those to march
//   y, z  those whose splits are taken four and two at a time
//   w     the place: the split where slot 0 begins (12 bits), log2 of the splits of a slot (4);
//         which points surfaces may hide from the tile (13), whether its lights are far from all of
//         it, whether its rays keep what they have met at the frame's depths
//         (glsl/shared/split_params.h), and in the highest bit whether no surface hides a light
//         from any of them
#pragma once
#include "shared/types.h"
FUM_SHARED_BEGIN

const int kLayerTile = 4;     // texels along the edge of a tile of the march
const int kPictureTile = 16;  // and pixels of one of the picture
const int kTileSlots = 31;    // of 32: the march looks for the end of a row of bits

FUM_SHARED_FUNCTION uint tile_place(int first_split, int log2_width, bool lit)
{
    return uint(first_split) | uint(log2_width) << 12u | (lit ? 0x80000000u : 0u);
}

const uint kTileKeepsDepths = 0x40000000u;
const uint kTileIsFar = 0x20000000u;

FUM_SHARED_FUNCTION bool tile_keeps_depths(uint place)
{
    return (place & kTileKeepsDepths) != 0u;
}
FUM_SHARED_FUNCTION int tile_first_split(uint place)
{
    return int(place & 0xfffu);
}
FUM_SHARED_FUNCTION int tile_log2_width(uint place)
{
    return int(place >> 12u & 15u);
}
// Points and spots that a surface may hide from a part of it, a bit each in their order; those
// beyond the last bit begin at the first again.
const int kTilePoints = 13;

FUM_SHARED_FUNCTION uint tile_shaded(uint points)
{
    return (points & 0x1fffu) << 16u;
}
FUM_SHARED_FUNCTION uint tile_shaded_points(uint place)
{
    return place >> 16u & 0x1fffu;
}
// Whether each light that has a place is far from its steps, against how long those are.
FUM_SHARED_FUNCTION bool tile_is_far(uint place)
{
    return (place & kTileIsFar) != 0u;
}
FUM_SHARED_FUNCTION bool tile_is_lit(uint place)
{
    return (place >> 31u) != 0u;
}

// The slot that holds a split; before and behind them the first and the last bit.
FUM_SHARED_FUNCTION int tile_slot(uint place, int split)
{
    int slot = (split - tile_first_split(place)) >> tile_log2_width(place);
    return slot < 0 ? 0 : slot > kTileSlots ? kTileSlots : slot;
}

// How many splits the step at one of them takes, of the tile's y and z.
FUM_SHARED_FUNCTION int tile_stride(uint fours, uint twos, uint place, int split)
{
    uint slot = uint(tile_slot(place, split));
    return ((fours >> slot) & 1u) != 0u ? 4 : ((twos >> slot) & 1u) != 0u ? 2 : 1;
}

FUM_SHARED_END
