// One transparent in one draw: into the lists of fragments, or over a picture.
#pragma once
#include "shared/types.h"
FUM_SHARED_BEGIN

// OpenGL's factors of blending, in the order of BlendFactor of <fumarole/scene.h>.
#define BLEND_ZERO 0u
#define BLEND_ONE 1u
#define BLEND_SRC_COLOR 2u
#define BLEND_ONE_MINUS_SRC_COLOR 3u
#define BLEND_DST_COLOR 4u
#define BLEND_ONE_MINUS_DST_COLOR 5u
#define BLEND_SRC_ALPHA 6u
#define BLEND_ONE_MINUS_SRC_ALPHA 7u
#define BLEND_DST_ALPHA 8u
#define BLEND_ONE_MINUS_DST_ALPHA 9u
#define BLEND_SRC_ALPHA_SATURATE 10u

// The blends by name, as pairs of factors: of the source, and of what is behind.
#define BLEND_ALPHA (BLEND_SRC_ALPHA << 4u | BLEND_ONE_MINUS_SRC_ALPHA)
#define BLEND_PREMULTIPLIED (BLEND_ONE << 4u | BLEND_ONE_MINUS_SRC_ALPHA)
#define BLEND_ADD (BLEND_ONE << 4u | BLEND_ONE)
#define BLEND_MULTIPLY (BLEND_ZERO << 4u | BLEND_SRC_COLOR)

// A fragment's key: which draw it is of, the lowest bits of its triangle's number there, and its
// two factors. Of two fragments at one depth the one with the larger key is in front.
const int kMostDraws = 4096;

FUM_SHARED_FUNCTION uint fragment_key(uint draw, uint source_factor, uint destination_factor)
{
    return draw << 20u | source_factor << 4u | destination_factor;
}
FUM_SHARED_FUNCTION uint fragment_key_of_triangle(uint key, uint triangle)
{
    return key | (triangle & 0xfffu) << 8u;
}
FUM_SHARED_FUNCTION uint fragment_source_factor(uint key)
{
    return key >> 4u & 15u;
}
FUM_SHARED_FUNCTION uint fragment_destination_factor(uint key)
{
    return key & 15u;
}

// Along how many lines a piece of a transparent is cut off at most.
#define MAX_CUTS 8

struct FUM_STD140 TransparentParams {
    mat4 clip_from_object;
    vec4 view_z_from_object;  // view_z [m] of p = dot(vec4(p, 1), this)
    vec4 source;              // radiance or filter, and alpha; of an image, what multiplies it
    vec4 faded;               // what that is once it has faded away
    vec4 fades;               // 1 for each of its channels that fades, else 0
    vec3 of_source;  // of the source's factor: what a constant, its colour and its alpha weigh
    uint is_filter;  // of an image: what it does not cover lets all through
    vec3 of_behind;  // the same of the factor of what is behind
    uint key;        // fragment_key()
    vec2 view_z;     // the near and the far plane's [m]
    float inverse_depth_fade;  // 1/m
    int pane;                  // which of the panes in order it is
    // Of a piece, lines of the picture, four in one: it has the pixels where the sign of
    // cut + cut_dx * NDC x + cut_dy * NDC y has the bit that cut_sign has.
    vec4 cut[MAX_CUTS / 4];
    vec4 cut_dx[MAX_CUTS / 4];
    vec4 cut_dy[MAX_CUTS / 4];
    ivec4 cut_sign[MAX_CUTS / 4];
};

FUM_SHARED_END
