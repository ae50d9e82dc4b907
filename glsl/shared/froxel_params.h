// The froxel grid of a frame: what of the view each froxel holds, and how last frame's grid lay.
// World space is eye-centred: see frame_params.h.
#include "shared/types.h"
FUM_SHARED_BEGIN

// Coefficients and sources are kept per range.z metres of ray and not per metre: a scene in
// millimetres keeps the same numbers as one in kilometres, and 16 bits hold both.
struct FroxelParams {
    vec4 grid;     // x, y: columns; z: slices; w: pixels along a tile's edge
    vec4 range;    // x, y: view_z [m] where the first slice begins and the last one ends; z: y - x;
                   // w: columns beyond the picture on each side
    vec4 spacing;  // see lib/froxel.glsl
    vec4 jitter;   // xyz: where in its froxel a sample lies, 0..1; w: weight of history
    mat4 clip_from_world;
    vec4 view_z_from_world;  // view_z of p = dot(vec4(p, 1), this)
    // The same of last frame, from this frame's world.
    mat4 history_clip_from_world;
    vec4 history_view_z_from_world;
    vec4 history_range;  // as range; w: this frame's range.z over its own
    vec4 history_eye;    // xyz: where the eye was [m]; w 0: orthographic, the direction to it
};

FUM_SHARED_END
