// The block of an inspection.
#include "shared/bindings.h"
#include "shared/inspect_params.h"

layout(std140, binding = INSPECT_BLOCK) uniform Inspect { InspectParams u_inspect; };
