// Where slices lie along view depth, and back: z = begin + (end - begin) t(s), s in 0..1 through the slices.
//   SLICES_LINEAR       t = s
//   SLICES_EXPONENTIAL  t = (exp2(rate s) - 1) / (exp2(rate) - 1), Eevee's of October 2017: its
//                       z = (exp2(s / d) - a) / b with a and b put in, and rate = 1 / d
//   SLICES_POWER        t = s^rate, after Wronski 2014
#include "shared/froxel_params.h"

float slice_view_z(float s, SliceParams slices)
{
    float t = s;
    if (slices.spacing == SLICES_EXPONENTIAL)
        t = (exp2(slices.rate * s) - 1.0) / slices.exp2_rate_1;
    else if (slices.spacing == SLICES_POWER)
        t = pow(s, slices.rate);
    return slices.begin + slices.depth * t;
}

// s of a view depth, held to 0..1.
float slice_at(float view_z, SliceParams slices)
{
    float t = clamp((view_z - slices.begin) / slices.depth, 0.0, 1.0);
    if (slices.spacing == SLICES_EXPONENTIAL)
        return log2(1.0 + t * slices.exp2_rate_1) / slices.rate;
    if (slices.spacing == SLICES_POWER)
        return pow(t, 1.0 / slices.rate);
    return t;
}

// view_z counted in slices, linear in depth within each: what is integrated along depth is linear
// there in a uniform medium, and an exponential s is not.
float slices_before(float view_z, SliceParams slices)
{
    float k = min(floor(slice_at(view_z, slices) * slices.count), slices.count - 1.0);
    float begin = slice_view_z(k / slices.count, slices);
    float end = slice_view_z((k + 1.0) / slices.count, slices);
    // A slice may be thinner than a 32-bit depth tells.
    return k + clamp((view_z - begin) / max(end - begin, 1e-30), 0.0, 1.0);
}
