// The upsample by fragments: resolve/upsample.glsl.
#include "resolve/upsample.glsl"
#include "resolve/blended.glsl"
