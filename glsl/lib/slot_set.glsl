// Sets of up to 64 slots of the march's step lattice, in two words, the first 32 in x: what
// src/pass/step_slots.h keeps in 64 bits.

uint slot_word(int first, int last)
{
    first = clamp(first, 0, 32);
    last = clamp(last, 0, 32);
    return last > first ? (~0u >> uint(32 - (last - first))) << uint(first) : 0u;
}

// Those from first to before last.
uvec2 slot_row(int first, int last) { return uvec2(slot_word(first, last), slot_word(first - 32, last - 32)); }

// Of a set that has some.
int first_slot(uvec2 slots) { return slots.x != 0u ? findLSB(slots.x) : 32 + findLSB(slots.y); }
int end_of_slots(uvec2 slots) { return slots.y != 0u ? 33 + findMSB(slots.y) : 1 + findMSB(slots.x); }
