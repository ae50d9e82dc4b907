// Froxels, step 3: what the integrated volumes hold before a pixel's own depth, to be blended over the
// picture.
//   in   the host's depth, integrated scattering and optical depth (pass/integrate.comp)
//   out  one layer: scattering, with the mean transmittance in alpha, or the transmittance, or BOTH at once
#include "lib/channels.glsl"
#include "lib/depth.glsl"
#include "scene/volume_at_froxels.glsl"

// Variant, besides BOTH
const bool kTransmittance = false;  // it alone is the colour

layout(binding = SCENE_DEPTH_UNIT) uniform sampler2D u_scene_depth_tx;
#include "resolve/resolved.glsl"

Resolved resolve_pixel(ivec2 pixel)
{
    float scene_z = view_z_of(texelFetch(u_scene_depth_tx, pixel, 0).r, u_frame.view_z_from_depth, u_frame.sky_depth);
    VolumeAt seen = volume_at(froxel_ray(vec2(pixel) + 0.5), scene_z);
    vec4 color = kTransmittance ? vec4(seen.transmittance, 1.0) : vec4(seen.scattering, mean(seen.transmittance));
    return Resolved(color, seen.transmittance);
}
