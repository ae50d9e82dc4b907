// Lists of transparent fragments, one a pixel: its first in an image, each with the number of the next. Numbers count
// from 1; 0 ends a list.
#include "shared/bindings.h"
#include "shared/transparent_params.h"

// Variant
const bool kHalfColor = false;  // colours have 16 bits a channel, as the picture's layers do; else 32

layout(r32ui, binding = FRAGMENT_LISTS_IMAGE) uniform uimage2D u_first_img;
layout(std430, binding = FRAGMENT_COUNT_BUFFER) buffer FragmentCount { uint u_fragment_count; };
layout(std430, binding = FRAGMENTS_BUFFER) buffer Fragments { uint u_fragments[]; };

struct Fragment {
    float view_z;  // metres
    uint key;      // shared/transparent_params.h
    vec4 source;   // radiance [W/m^2/sr] or what a filter lets through, and alpha
};

int fragment_words() { return kHalfColor ? 5 : 7; }  // next, view_z, key, colour
int fragment_word(uint number) { return (int(number) - 1) * fragment_words(); }

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
    if (number > uint(u_fragments.length() / fragment_words()))
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
