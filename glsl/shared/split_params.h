// The depths at which the march keeps what it has met so far: the same for all rays of a frame.
#pragma once
#include "shared/types.h"
FUM_SHARED_BEGIN

#define MAX_SPLITS 64

struct FUM_STD140 SplitParams {
    vec4 view_z[MAX_SPLITS / 4];  // [m], ascending, four in one; beyond count, beyond all
    int count;                    // 2 at least
    int unused_x, unused_y, unused_z;
};

FUM_SHARED_END
