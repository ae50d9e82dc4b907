// The frame's block, and its rays.
#include "shared/bindings.h"
#include "shared/frame_params.h"

// Variant
const int kLayerScale = 1;  // pixels along the edge of a texel of the volume layer: 1, 2 or 4

#ifndef u_frame  // a host's shader has it in a block of its own
layout(std140, binding = FRAME_BLOCK) uniform Frame { FrameParams u_frame; };
#endif

struct Ray {
    vec3 origin;     // eye-centred world [m]
    vec3 direction;  // per metre of view depth: p = origin + direction * view_z
};

Ray camera_ray(vec2 ndc)
{
    return Ray(u_frame.ray_origin.xyz + ndc.x * u_frame.ray_origin_dx.xyz + ndc.y * u_frame.ray_origin_dy.xyz,
               u_frame.ray_direction.xyz + ndc.x * u_frame.ray_direction_dx.xyz + ndc.y * u_frame.ray_direction_dy.xyz);
}
