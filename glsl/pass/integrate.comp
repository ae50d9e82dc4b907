// Froxels, step 2: front to back along each column's own ray, to the ends of its slices.
//   in   source and extinction of the froxels
//   out  scattering, transmittance   from the eye to the end of each slice, as a ray along the view's axis
//        would see them (lib/slab.glsl): the same for every column in a uniform medium, so what is
//        interpolated between columns is exact in one, at the picture's corners too
//        Texel k along z holds what is before slice k. For lookups that reach past the ends it is texel k + 1, and
//        the first and the last one continue the line.
// Transmittance and not optical depth is kept: half way between a dense column and an empty one, half of
// the light passes. A mean of optical depths would spread the dense one (5 % too much scattering by smoke
// at tiles of 8 pixels, where this has 2 %).
//
#include "lib/slab.glsl"
#include "scene/froxels.glsl"
#include "scene/froxel_extinction.glsl"

// Variant
const bool kWronski = false;  // a slice's source is not dimmed within the slice, Wronski 2014: gains energy

layout(local_size_x = FROXEL_COLUMNS, local_size_y = FROXEL_COLUMNS) in;
layout(binding = INTEGRATED_SCATTERING_IMAGE) writeonly uniform image3D u_scattering_img;
layout(binding = FROXEL_SOURCE_UNIT) uniform sampler3D u_source_tx;
layout(binding = INTEGRATED_TRANSMITTANCE_IMAGE) writeonly uniform image3D u_transmittance_img;
layout(binding = FROXEL_EXTINCTION_UNIT) uniform sampler3D u_extinction_tx;

struct Integrated {
    vec3 scattering;
    volume_depth_t transmittance;
};

void store(ivec2 column, int z, Integrated value)
{
    vec3 transmittance = vec3(value.transmittance);
    float alpha = kExtinctionInAlpha || kRedInAlpha ? transmittance.r : 0.0;
    imageStore(u_scattering_img, ivec3(column, z), vec4(value.scattering, alpha));
    if (!kExtinctionInAlpha)
        imageStore(u_transmittance_img, ivec3(column, z), extinction_apart(transmittance));
}

Integrated continued(Integrated a, Integrated b)
{
    return Integrated(2.0 * b.scattering - a.scattering, 2.0 * b.transmittance - a.transmittance);
}

void main()
{
    ivec3 count = froxel_count();
    ivec2 column = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(column, count.xy)))
        return;
    float length_per_z = length(column_ray(column, vec2(0.5)).direction);
    vec3 radiance = vec3(0.0);
    volume_depth_t tau = volume_depth_t(0.0);
    Integrated before = Integrated(vec3(0.0), volume_depth_t(1.0));
    Integrated value = before;
    int front = texels_before_front();
    store(column, front, value);
    float begin = slice_begin(0);
    for (int k = 0; k < count.z; ++k) {
        float end = slice_begin(k + 1);
        float thickness = (end - begin) * length_per_z / u_froxels.slices.depth;
        begin = end;
        vec4 source = texelFetch(u_source_tx, ivec3(column, k), 0) * thickness;
        vec4 apart = vec4(0.0);
        if (!has_one_extinction())
            apart = texelFetch(u_extinction_tx, ivec3(column, k), 0) * thickness;
        volume_depth_t slice_tau = volume_depth_t(extinction_of_kept(source, apart));
        vec3 added = exp(-tau) * source.rgb;
        if (!kWronski)
            added *= slab_weight(slice_tau);
        radiance += added;
        tau += slice_tau;
        before = value;
        value.scattering = min(seen_at_slant(radiance, tau, 1.0 / length_per_z), vec3(u_frame.radiance_limit));
        value.transmittance = exp(-tau / length_per_z);
        store(column, front + k + 1, value);
        if (kTricubic && k == 0)
            store(column, 0, continued(value, before));
    }
    if (kTricubic)
        store(column, count.z + 2, continued(before, value));
}
