// Rounding to the halves, floats of 16 bits, that a mean is kept in from frame to frame. Rounded to the nearest it
// stalls: a step of less than half a unit in the last place leaves it where it was. Rounded up as often as what is
// cut off is of a unit, it goes where it would have gone, on average.
//   dither  0..2^32 - 1. Evenly spread over frames, the errors of a place make up for each other: half as much is
//           left of them as of random numbers after 1000 frames.

// A half, as a float; of one past what they hold the largest one.
float dithered_half(float value, uint dither)
{
    const float kLeastNormal = 6.103515625e-5, kLeast = 5.9604644775390625e-8, kMost = 65504.0;
    // Below the least normal one halves have one spacing, and a float's last bits say nothing of theirs.
    if (abs(value) < kLeastNormal)
        return floor(value / kLeast + float(dither >> 8u) * exp2(-24.0)) * kLeast;
    // A float has 13 bits more, and the carry of their sum is the rounding, into the next exponent too.
    return clamp(uintBitsToFloat((floatBitsToUint(value) + (dither >> 19u)) & 0xffffe000u), -kMost, kMost);
}

// Of the frame of a number, from the dithers of a place in the first one: the golden ratio's multiples are spread as
// evenly as any are.
uvec2 dither_of_frame(uvec2 first, uint frame) { return first + frame * 2654435769u; }
