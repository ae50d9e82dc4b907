// How pictures are shown in a window.
#include "shared/types.h"
FUM_SHARED_BEGIN

struct DisplayParams {
    vec4 area;  // xy: lower left of the picture in the window; zw: its size, pixels
    vec4 tone;  // x: radiance is multiplied by it; y: 1 filmic, 0 sRGB alone; z, w: likewise of B
    vec4 comparison;  // x: pixels from the left where B begins; y: the difference at the end of the
                      // scale; z: 0.1 mean(B^2)
};

FUM_SHARED_END
