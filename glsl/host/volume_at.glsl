// What the media do before any depth of a pixel, for a host's own shaders: one text for a march, for froxels and for
// every scene.
//   in   what View::volume_at() names
#include "shared/bindings.h"
#include "shared/volume_at_params.h"

layout(std140, binding = VOLUME_AT_BLOCK) uniform VolumeAtBlock { VolumeAtParams u_volume_at; };
#define u_frame u_volume_at.frame
#define u_froxels u_volume_at.froxels
#define u_splits u_volume_at.splits
#include "scene/volume_at_froxels.glsl"
#include "scene/volume_at_splits.glsl"

// pixel: of the frame's picture, from its lower left, as gl_FragCoord.xy is; view_z: metres along the view's axis
VolumeAt volume_at(vec2 pixel, float view_z)
{
    if (u_volume_at.kind == VOLUME_AT_FROXELS)
        return volume_at(froxel_ray(pixel), view_z);
    if (u_volume_at.kind == VOLUME_AT_SPLITS)
        return volume_at(split_ray(pixel), view_z);
    return VolumeAt(vec3(0.0), vec3(1.0));
}
