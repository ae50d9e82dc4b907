// The 32 bits of a page of a grid in bricks. Of a brick: the top one is set, then 7 bits are its
// scale and 8 each of z, y and x its slot in the atlas, in bricks. Else it is a constant, 0 where
// nothing is: the bits of a float >= 0 without its sign, its last mantissa bit rounded away.
#pragma once
#include "shared/types.h"
FUM_SHARED_BEGIN

const uint kPageBrick = 0x80000000u;

FUM_SHARED_FUNCTION bool is_brick(uint page)
{
    return page >= kPageBrick;
}

FUM_SHARED_FUNCTION uint brick_page(uint slot_x, uint slot_y, uint slot_z, uint scale_step)
{
    return kPageBrick | scale_step << 24u | slot_z << 16u | slot_y << 8u | slot_x;
}

FUM_SHARED_FUNCTION uint page_slot_x(uint page)
{
    return page & 255u;
}
FUM_SHARED_FUNCTION uint page_slot_y(uint page)
{
    return page >> 8u & 255u;
}
FUM_SHARED_FUNCTION uint page_slot_z(uint page)
{
    return page >> 16u & 255u;
}

// The bits of the float that a brick's texels are multiplied by: 1 at step 0, and a step is 2^20 of
// them, an eighth of the octave that it lies in.
FUM_SHARED_FUNCTION uint scale_step_bits(uint scale_step)
{
    return 0x3f800000u - (scale_step << 20u);
}
// The step of the least scale that is not under a value of up to 1, by its bits.
FUM_SHARED_FUNCTION uint scale_step_above(uint bits)
{
    return (0x3f800000u - bits) >> 20u;
}
FUM_SHARED_FUNCTION uint page_scale_bits(uint page)
{
    return scale_step_bits(page >> 24u & 127u);
}

// Of a constant: the bits of its value, and back.
FUM_SHARED_FUNCTION uint page_constant_bits(uint page)
{
    return page << 1u;
}
FUM_SHARED_FUNCTION uint constant_page(uint bits)
{
    return (bits + 1u < 0x7f800000u ? bits + 1u : bits) >> 1u;  // rounded, never to infinity
}

FUM_SHARED_END
