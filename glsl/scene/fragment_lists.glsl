// Lists of transparent fragments, one a pixel: its first in an image, each with the number of the next. Numbers count
// from 1; 0 ends a list.
#include "shared/bindings.h"
#include "shared/transparent_params.h"

// Variant
const bool kHalfColor = false;  // colours have 16 bits a channel, as the picture's layers do; else 32

layout(r32ui, binding = FRAGMENT_LISTS_IMAGE) uniform uimage2D u_first_img;
layout(std430, binding = FRAGMENT_COUNT_BUFFER) buffer FragmentCount { uint u_fragment_count; };
layout(std430, binding = FRAGMENTS_BUFFER) buffer Fragments { uint u_fragments[]; };

const int kFragmentWords = kHalfColor ? 5 : 7;  // next, view_z, key, colour

struct Fragment {
    float view_z;  // metres
    uint key;      // shared/transparent_params.h
    vec4 source;   // radiance [W/m^2/sr] or what a filter lets through, and alpha
};

int fragment_word(uint number) { return (int(number) - 1) * kFragmentWords; }

uint first_fragment(ivec2 pixel) { return imageLoad(u_first_img, pixel).r; }
uint next_fragment(uint number) { return u_fragments[fragment_word(number)]; }
float fragment_view_z(uint number) { return uintBitsToFloat(u_fragments[fragment_word(number) + 1]); }
uint fragment_key_at(uint number) { return u_fragments[fragment_word(number) + 2]; }

vec4 fragment_source(uint number)
{
    int word = fragment_word(number) + 3;
    if (kHalfColor)
        return vec4(unpackHalf2x16(u_fragments[word]), unpackHalf2x16(u_fragments[word + 1]));
    return vec4(uintBitsToFloat(u_fragments[word]), uintBitsToFloat(u_fragments[word + 1]),
                uintBitsToFloat(u_fragments[word + 2]), uintBitsToFloat(u_fragments[word + 3]));
}

// Counts those that do not fit as well: the next frames' buffer is made so large.
void add_fragment(ivec2 pixel, Fragment fragment)
{
    uint number = atomicAdd(u_fragment_count, 1u) + 1u;
    if (number > uint(u_fragments.length() / kFragmentWords))
        return;
    int word = fragment_word(number);
    u_fragments[word] = imageAtomicExchange(u_first_img, pixel, number);
    u_fragments[word + 1] = floatBitsToUint(fragment.view_z);
    u_fragments[word + 2] = fragment.key;
    if (kHalfColor) {
        u_fragments[word + 3] = packHalf2x16(fragment.source.rg);
        u_fragments[word + 4] = packHalf2x16(fragment.source.ba);
        return;
    }
    u_fragments[word + 3] = floatBitsToUint(fragment.source.r);
    u_fragments[word + 4] = floatBitsToUint(fragment.source.g);
    u_fragments[word + 5] = floatBitsToUint(fragment.source.b);
    u_fragments[word + 6] = floatBitsToUint(fragment.source.a);
}

void link_fragment(uint number, uint next)
{
    if (next_fragment(number) != next)
        u_fragments[fragment_word(number)] = next;
}

// Whether the first lies behind the second.
bool is_behind(float view_z, uint key, float other_view_z, uint other_key)
{
    return view_z > other_view_z || (view_z == other_view_z && key < other_key);
}

// Puts a list in order from the farthest to the nearest, by insertion: nothing is written to one that is in order,
// as lists are where draws come the nearest first and do not cross. @returns its first; 0 if there is none
uint sort_fragments(ivec2 pixel)
{
    uint first = first_fragment(pixel);
    if (first == 0u)
        return 0u;
    uint head = first, tail = first;
    float tail_z = fragment_view_z(tail);
    uint tail_key = fragment_key_at(tail);
    uint at = next_fragment(first);
    if (at != 0u) do {
        uint next = next_fragment(at);
        float view_z = fragment_view_z(at);
        uint key = fragment_key_at(at);
        if (!is_behind(view_z, key, tail_z, tail_key)) {
            link_fragment(tail, at);
            tail = at;
            tail_z = view_z;
            tail_key = key;
        } else {
            uint before = 0u, after = head;
            if (is_behind(fragment_view_z(after), fragment_key_at(after), view_z, key)) do {
                before = after;
                after = next_fragment(after);
            } while (is_behind(fragment_view_z(after), fragment_key_at(after), view_z, key));
            link_fragment(at, after);
            if (before == 0u)
                head = at;
            else
                link_fragment(before, at);
        }
        at = next;
    } while (at != 0u);
    link_fragment(tail, 0u);
    if (head != first)
        imageStore(u_first_img, pixel, uvec4(head));
    return head;
}
