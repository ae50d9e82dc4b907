// The depths at which a march keeps what it has met so far.
#include "shared/bindings.h"
#include "shared/split_params.h"

layout(std140, binding = SPLITS_BLOCK) uniform Splits { SplitParams u_splits; };

float split_view_z(int k) { return u_splits.view_z[k >> 2][k & 3]; }
