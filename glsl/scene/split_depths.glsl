// The depths at which a march keeps what it has met so far.
#include "shared/bindings.h"
#include "shared/split_params.h"

#ifndef u_splits  // a host's shader has it in a block of its own
layout(std140, binding = SPLITS_BLOCK) uniform Splits { SplitParams u_splits; };
#endif

// Variant: as many as there may be, by fours
const int kSplitFours = MAX_SPLITS / 4;

float split_view_z(int k) { return u_splits.view_z[k >> 2][k & 3]; }
