// How last frame's layer lay, for the march's history. World space is eye-centred, this frame's:
// see frame_params.h.
#include "shared/types.h"
FUM_SHARED_BEGIN

struct FUM_STD140 MarchHistoryParams {
    mat4 clip_from_world;
    vec4 view_z_from_world;  // view_z of p = dot(vec4(p, 1), this)
    vec4 eye;                // xyz: where the eye was [m]; w 0: orthographic, the direction to it
    vec2 media_range;        // as frame_params.h has it
    vec2 layer_offset;       // likewise
    float media_depth;       // likewise
    float weight;            // of history, 0..1
};

FUM_SHARED_END
