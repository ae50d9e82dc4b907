// The lookup of froxels by fragments: resolve/froxels.glsl.
#include "resolve/froxels.glsl"
#include "resolve/blended.glsl"
