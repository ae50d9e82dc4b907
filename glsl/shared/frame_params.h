// What all passes of a frame know of its camera and its steps.
//
// World space on the GPU is the world's axes and metres with the origin at the eye: a scene a
// thousand kilometres from the world's origin keeps its precision. Matrices are composed in double.
#pragma once
#include "shared/types.h"
FUM_SHARED_BEGIN

struct FUM_STD140 FrameParams {
    // A pixel's ray: p(view_z) = origin + direction * view_z. Both are affine in NDC x, y:
    // centre + x * dx + y * dy. The direction's view depth is 1, so its length is metres of ray per
    // metre of view depth; it is 0 0 -1 turned to the world for an orthographic camera. xyz alone.
    vec4 ray_origin;
    vec4 ray_origin_dx;
    vec4 ray_origin_dy;
    vec4 ray_direction;
    vec4 ray_direction_dx;
    vec4 ray_direction_dy;

    // view_z = (x * depth + y) / (z * depth + w), of the depth that the host's buffer holds, from
    // its projection's own matrix: any convention, finite or infinite.
    vec4 view_z_from_depth;

    vec2 full_size;           // pixels of the scene
    vec2 inverse_full_size;   // 1 / pixels
    vec2 layer_size;          // texels of the volume layer
    vec2 inverse_layer_size;  // 1 / texels
    // From the middle of texel i to its sample at (i + 1/2 + offset) texels of the picture: less
    // the layer's guard band, plus what varies from frame to frame where frames are averaged.
    vec2 layer_offset;
    vec2 layer_offset_pixels;  // the same in whole pixels

    vec2 step_range;          // view_z [m] of the first and the last step's end
    vec2 media_range;         // view_z [m] within which media can be: nearest, farthest
    float step_octaves;       // log2(last / first) of step_range
    float media_depth;        // farthest - nearest [m] of media_range if orthographic, else 0
    float steps;              // of the march over step_range
    float distribution;       // of the steps: 0 linear .. 1 exponential
    float step_jitter;        // of a step, 0..1, added to each pixel's own
    float shadow_steps;       // towards a light
    float min_transmittance;  // the march ends once less than this passes
    float min_extinction;     // that media are given at least [1/m]
    float g_clamp;            // the largest |g| of the phase function
    float radiance_limit;     // largest value that the layer's format holds
    float depth_threshold;    // within which two depths are one surface, a part of the depth
    float sky_depth;          // what the host's buffer holds where nothing was drawn
};

FUM_SHARED_END
