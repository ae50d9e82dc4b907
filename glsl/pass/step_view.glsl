// A frame's step lattice, and the texel of a tile in it, for choose_steps.comp: StepSlots of src/pass/step_slots.cpp once
// more, in the same doubles. That one is the rule, and serves frames whose tiles the CPU works out; this is its copy for
// those whose tiles never leave the GPU. tests/gpu/step_tiles_test.cpp holds both equal to the bit: change them together.
#include "lib/slot_set.glsl"
#include "shared/bindings.h"
#include "shared/step_boxes.h"
#include "shared/step_tile.h"

layout(std140, binding = STEP_VIEW_BLOCK) uniform StepView { StepViewParams u_view; };

double slot_end(int i) { return u_view.ends[i >> 1][i & 1]; }
double split_length(int i) { return u_view.lengths[i >> 1][i & 1]; }

uvec2 all_slots() { return slot_row(0, u_view.slot_count); }

// Those that view_z from low to high lies in. Outside the range the first and the last.
uvec2 slots_between(double low, double high)
{
    int first = 1, beyond = u_view.slot_count;  // the first end after low
    while (first < beyond) {
        int middle = (first + beyond) >> 1;
        if (slot_end(middle) > low)
            beyond = middle;
        else
            first = middle + 1;
    }
    int last = first;  // the first from there on that is not before high
    beyond = u_view.slot_count;
    while (last < beyond) {
        int middle = (last + beyond) >> 1;
        if (slot_end(middle) < high)
            last = middle + 1;
        else
            beyond = middle;
    }
    return slot_row(first - 1, last);
}

// Those whose splits, so many in one, are no longer than `longest`: splits grow with depth.
uvec2 joined_slots(int many, double longest)
{
    int end = 0, beyond = u_view.slot_count;
    while (end < beyond) {
        int middle = (end + beyond) >> 1;
        if (double(many) * split_length(middle) <= longest)
            end = middle + 1;
        else
            beyond = middle;
    }
    return slot_row(0, (end * u_view.slot_width & -many) / u_view.slot_width);
}

// What a tile has to know of its slots: StepSlots::Held.
struct HeldSlots {
    uvec2 slots, shafts;
    double longest, longest_in_shaft;
    double far_from;
    bool lit;
};

uvec2 taken_slots(int many, HeldSlots held)
{
    return (joined_slots(many, held.longest) & ~held.shafts) |
           (joined_slots(many, held.longest_in_shaft) & held.shafts);
}

// The texel of a tile, in slots of its own: shared/step_tile.h.
uvec4 step_tile(HeldSlots held)
{
    if (held.slots == uvec2(0u))
        return uvec4(0u);
    int unit = u_view.slot_width;
    uvec2 fours = taken_slots(4, held), twos = taken_slots(2, held);
    int first = first_slot(held.slots), end = end_of_slots(held.slots);
    bool has_fours = (fours & held.slots) != uvec2(0u), has_twos = (twos & held.slots) != uvec2(0u);
    int width = max(unit, has_fours ? 4 : has_twos ? 2 : 1);
    while (end * unit - (first * unit & -width) > kTileSlots * width)
        width *= 2;
    int base = first * unit & -width;
    int slots = width / unit;
    uvec4 texel = uvec4(0u, 0u, 0u, tile_place(base, findLSB(uint(width)), held.lit) | tile_shaded(~0u));
    if (double(has_fours ? 4 : has_twos ? 2 : 1) * split_length(end - 1) <= held.far_from)
        texel.w |= kTileIsFar;
    uint bit = 1u;
    for (int i = base / unit; i < end; i += slots, bit <<= 1u) {
        uvec2 these = slot_row(i, min(i + slots, STEP_SLOTS));
        if ((held.slots & these) == uvec2(0u))
            continue;
        texel.x |= bit;
        // A lattice ends where it does: what is left of a slot may be taken as one.
        uvec2 there = these & all_slots();
        if ((fours & there) == there)
            texel.y |= bit;
        else if ((twos & there) == there)
            texel.z |= bit;
    }
    return texel;
}

// Tiles of so many pixels that low to high lies in: of both, as first and last.
ivec4 tiles_between(dvec2 low, dvec2 high, double pixels, ivec2 count)
{
    dvec2 most = dvec2(count);
    return ivec4(max(ivec2(clamp(floor(low / pixels), dvec2(-1.0), most)), ivec2(0)),
                 min(ivec2(clamp(floor(high / pixels), dvec2(-1.0), most)), count - 1));
}
