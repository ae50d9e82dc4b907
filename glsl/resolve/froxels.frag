// Froxels, step 4: what the integrated volumes hold before a pixel's own depth, to be blended over the
// picture.
//   in   the host's depth, integrated scattering and optical depth (pass/integrate.comp)
//   out  one layer: scattering, with the mean transmittance in alpha, or the transmittance, or BOTH at once
#include "lib/depth.glsl"
#include "scene/volume_at_froxels.glsl"

// Variant. BOTH: the transmittance is the second source of blending.
const bool kTransmittance = false;  // it alone is the colour

layout(binding = SCENE_DEPTH_UNIT) uniform sampler2D u_scene_depth_tx;
#ifdef BOTH
layout(location = 0, index = 0) out vec4 out_color;
layout(location = 0, index = 1) out vec4 out_transmittance;
#else
layout(location = 0) out vec4 out_color;
#endif

void main()
{
    float scene_z = view_z_of(texelFetch(u_scene_depth_tx, ivec2(gl_FragCoord.xy), 0).r,
                              u_frame.view_z_from_depth, u_frame.sky_depth);
    VolumeAt seen = volume_at(froxel_ray(gl_FragCoord.xy), scene_z);
    out_color = kTransmittance ? vec4(seen.transmittance, 1.0)
                               : vec4(seen.scattering, dot(seen.transmittance, vec3(1.0 / 3.0)));
#ifdef BOTH
    out_transmittance = vec4(seen.transmittance, 1.0);
#endif
}
