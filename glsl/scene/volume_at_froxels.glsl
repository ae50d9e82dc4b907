// What integrated froxels (pass/integrate.comp) hold before a depth. Nothing is integrated past a surface.
// Neighbouring columns are interpolated across the edges of surfaces: what is before one surface is as good for the
// other, as far as both reach.
#include "lib/slab.glsl"
#include "lib/tricubic.glsl"
#include "lib/volume_at.glsl"
#include "scene/froxels.glsl"

layout(binding = INTEGRATED_SCATTERING_UNIT) uniform sampler3D u_scattering_tx;
layout(binding = INTEGRATED_TRANSMITTANCE_UNIT) uniform sampler3D u_transmittance_tx;

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
    float front = float(texels_before_front());
    vec3 uvw = vec3(columns, front + z + 0.5) / vec3(u_froxels.columns, u_froxels.slices.count + 1.0 + 2.0 * front);
    vec4 scattering = lookup(u_scattering_tx, uvw);
    volume_depth_t tau = -log(clamp(volume_depth(scattering, lookup(u_transmittance_tx, uvw)), kLeast, 1.0));
    return Before(max(scattering.rgb, 0.0) / slab_weight(tau), tau);
}

// A pixel's ray, whatever the depth.
struct FroxelRay {
    vec2 columns;
    float length_per_z;
};

FroxelRay froxel_ray(vec2 pixel)
{
    float length_per_z = length(camera_ray(pixel * u_frame.inverse_full_size * 2.0 - 1.0).direction);
    return FroxelRay(columns_at(pixel), length_per_z);
}

VolumeAt volume_at(FroxelRay ray, float view_z)
{
    float z = slices_before(view_z, u_froxels.slices);
    Before seen;
    if (kTricubic) {
        seen = before(ray.columns, z);
    } else {
        // Not by the texture unit: its weights between slices may have 8 bits.
        float k = min(floor(z), u_froxels.slices.count - 1.0);
        seen = before(ray.columns, k);
        Before next = before(ray.columns, k + 1.0);
        seen.source = mix(seen.source, next.source, z - k);
        seen.tau = mix(seen.tau, next.tau, z - k);
    }
    volume_depth_t tau = seen.tau * ray.length_per_z;
    return VolumeAt(seen.source * ray.length_per_z * slab_weight(tau), vec3(exp(-tau)));
}

VolumeAt volume_at_pane(FroxelRay ray, int k, float view_z) { return volume_at(ray, view_z); }
