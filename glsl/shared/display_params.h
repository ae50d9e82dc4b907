// How pictures are shown in a window.
#include "shared/types.h"
FUM_SHARED_BEGIN

// Of one picture.
struct FUM_STD140 ToneParams {
    float exposure;  // radiance is multiplied by it
    float filmic;    // 1: the filmic transform; 0: sRGB alone
};

struct FUM_STD140 DisplayParams {
    ToneParams tone_a, tone_b;
    vec2 lower_left;           // of the picture in the window, pixels
    vec2 size;                 // pixels
    float wipe;                // pixels from the left where B begins
    float largest_difference;  // at the end of the scale
    float tenth_mean_square;   // 0.1 mean(B^2)
};

FUM_SHARED_END
