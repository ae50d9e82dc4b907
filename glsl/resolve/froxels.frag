// Froxels, step 4: what the integrated volumes hold before a pixel's own depth, to be blended over the
// picture. Nothing is integrated past a surface. Neighbouring columns are interpolated across the edges of
// surfaces: what is before one surface is as good for the other, as far as both reach.
//   in   the host's depth, integrated scattering and optical depth (pass/integrate.comp)
//   out  one layer: scattering, with the mean transmittance in alpha, or the transmittance, or BOTH at once
#include "lib/depth.glsl"
#include "lib/slab.glsl"
#include "lib/tricubic.glsl"
#include "scene/froxels.glsl"

// Variant. BOTH: the transmittance is the second source of blending.
const bool kTransmittance = false;  // it alone is the colour
const bool kTricubic = false;  // a B-spline over 4^3 texels, which smooths along depth as well; else bilinear between
                               // columns and, within a slice, exact where it is uniform

layout(binding = SCENE_DEPTH_UNIT) uniform sampler2D u_scene_depth_tx;
layout(binding = INTEGRATED_SCATTERING_UNIT) uniform sampler3D u_scattering_tx;
layout(binding = INTEGRATED_TRANSMITTANCE_UNIT) uniform sampler3D u_transmittance_tx;
#ifdef BOTH
layout(location = 0, index = 0) out vec4 out_color;
layout(location = 0, index = 1) out vec4 out_transmittance;
#else
layout(location = 0) out vec4 out_color;
#endif

vec4 lookup(sampler3D volume, vec3 uvw)
{
    if (kTricubic)
        return texture_tricubic(volume, uvw);
    return textureLod(volume, uvw, 0.0);
}

// What is before a place in the grid, along the view's axis: optical depth, and the sum of the sources as
// if nothing dimmed them. Both grow linearly in a uniform medium.
struct Before {
    vec3 source;
    volume_depth_t tau;
};

// z: in slices from the grid's front.
Before before(vec2 columns, float z)
{
    const float kLeast = 1e-30;  // what no format tells from 0
    vec3 uvw = vec3(columns, z + 1.5) / vec3(u_froxels.columns, u_froxels.slices.count + 3.0);
    vec4 scattering = lookup(u_scattering_tx, uvw);
    volume_depth_t tau = -log(clamp(volume_depth(scattering, lookup(u_transmittance_tx, uvw)), kLeast, 1.0));
    return Before(max(scattering.rgb, 0.0) / slab_weight(tau), tau);
}

void main()
{
    float scene_z = view_z_of(texelFetch(u_scene_depth_tx, ivec2(gl_FragCoord.xy), 0).r,
                              u_frame.view_z_from_depth, u_frame.sky_depth);
    float length_per_z = length(camera_ray(gl_FragCoord.xy * u_frame.inverse_full_size * 2.0 - 1.0).direction);
    float z = slices_before(scene_z, u_froxels.slices);
    vec2 columns = columns_at(gl_FragCoord.xy);
    Before seen;
    if (kTricubic) {
        seen = before(columns, z);
    } else {
        // Not by the texture unit: its weights between slices may have 8 bits.
        float k = min(floor(z), u_froxels.slices.count - 1.0);
        seen = before(columns, k);
        Before next = before(columns, k + 1.0);
        seen.source = mix(seen.source, next.source, z - k);
        seen.tau = mix(seen.tau, next.tau, z - k);
    }
    volume_depth_t tau = seen.tau * length_per_z;
    vec3 transmittance = vec3(exp(-tau));
    vec3 scattering = seen.source * length_per_z * slab_weight(tau);
    out_color = kTransmittance ? vec4(transmittance, 1.0) : vec4(scattering, dot(transmittance, vec3(1.0 / 3.0)));
#ifdef BOTH
    out_transmittance = vec4(transmittance, 1.0);
#endif
}
