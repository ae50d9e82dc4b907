// What a march kept before a depth, of the rays around a pixel.
//   in   a layer a depth (scene/split_depths.glsl): scattering, and, kMonochrome, transmittance in its alpha
//        the march's layer depth (view_z [m] where each of its rays ends)
#include "lib/volume_at.glsl"
#include "scene/frame.glsl"
#include "scene/split_depths.glsl"

// Variant
const bool kMonochrome = false;

layout(binding = LAYER_DEPTH_UNIT) uniform sampler2D u_layer_depth_tx;
layout(binding = SPLIT_SCATTERING_UNIT) uniform sampler2DArray u_split_scattering_tx;
layout(binding = SPLIT_TRANSMITTANCE_UNIT) uniform sampler2DArray u_split_transmittance_tx;

// A pixel's place among the march's rays, whatever the depth.
struct SplitRay {
    vec2 texel;   // the rays lie at integers
    vec4 reach;   // view_z [m] where the four around it end: upper left, upper right, lower right, lower left
};

SplitRay split_ray(vec2 pixel)
{
    SplitRay ray;
    ray.texel = pixel / float(kLayerScale) - 0.5 - u_frame.layer_offset;
    ray.reach = textureGather(u_layer_depth_tx, (floor(ray.texel) + 1.0) * u_frame.inverse_layer_size);
    return ray;
}

VolumeAt split_texel(ivec2 texel, int k)
{
    texel = clamp(texel, ivec2(0), ivec2(u_frame.layer_size) - 1);
    vec4 scattering = texelFetch(u_split_scattering_tx, ivec3(texel, k), 0);
    if (kMonochrome)
        return VolumeAt(scattering.rgb, vec3(scattering.a));
    return VolumeAt(scattering.rgb, texelFetch(u_split_transmittance_tx, ivec3(texel, k), 0).rgb);
}

// weights: as SplitRay::reach; they add up to 1
VolumeAt split_weighted(SplitRay ray, int k, vec4 weights)
{
    const ivec2 kPlace[4] = ivec2[](ivec2(0, 1), ivec2(1, 1), ivec2(1, 0), ivec2(0, 0));
    VolumeAt sum = VolumeAt(vec3(0.0), vec3(0.0));
    for (int i = 0; i < 4; ++i) {
        VolumeAt one = split_texel(ivec2(floor(ray.texel)) + kPlace[i], k);
        sum.scattering += weights[i] * one.scattering;
        sum.transmittance += weights[i] * one.transmittance;
    }
    return sum;
}

VolumeAt split_bilinear(SplitRay ray, int k)
{
    vec3 uv = vec3((ray.texel + 0.5) * u_frame.inverse_layer_size, float(k));
    vec4 scattering = textureLod(u_split_scattering_tx, uv, 0.0);
    if (kMonochrome)
        return VolumeAt(scattering.rgb, vec3(scattering.a));
    return VolumeAt(scattering.rgb, textureLod(u_split_transmittance_tx, uv, 0.0).rgb);
}

// Between two depths, as in a uniform medium: optical depth grows evenly, and what is scattered in by as much as is
// dimmed away.
VolumeAt split_between(VolumeAt near, VolumeAt far, float share)
{
    const float kLeast = 1e-30;  // what no format tells from 0
    const float kThin = 1e-3;    // difference of transmittances below which both grow evenly
    vec3 dims = near.transmittance - far.transmittance;
    vec3 transmittance = near.transmittance * pow(clamp(far.transmittance / max(near.transmittance, kLeast), kLeast, 1.0),
                                                  vec3(share));
    vec3 scattered = mix((near.transmittance - transmittance) / max(dims, kThin), vec3(share), lessThan(dims, vec3(kThin)));
    return VolumeAt(mix(near.scattering, far.scattering, scattered), transmittance);
}

VolumeAt volume_at(SplitRay ray, float view_z)
{
    int low = 0, high = u_splits.count - 1;
    do {  // llvmpipe runs a while body once more with all lanes masked; do-while avoids it.
        int middle = (low + high) >> 1;
        if (split_view_z(middle) <= view_z)
            low = middle;
        else
            high = middle;
    } while (high - low > 1);
    float begin = split_view_z(low), end = split_view_z(high);
    float share = clamp((view_z - begin) / max(end - begin, 1e-30), 0.0, 1.0);

    // A ray that ends before this depth, at a surface, knows nothing of what lies there.
    bvec4 short_of = lessThan(ray.reach, vec4(min(view_z, u_frame.media_range.y)));
    VolumeAt near, far;
    if (kLayerScale == 1) {
        ivec2 texel = ivec2(round(ray.texel));
        near = split_texel(texel, low);
        far = split_texel(texel, high);
    } else if (!any(short_of)) {
        near = split_bilinear(ray, low);
        far = split_bilinear(ray, high);
    } else {
        const float kShort = 1e-4;  // where all are
        vec2 h = ray.texel - floor(ray.texel), l = 1.0 - h;
        vec4 weights = vec4(l.x * h.y, h.x * h.y, h.x * l.y, l.x * l.y) * mix(vec4(1.0), vec4(kShort), short_of) + 1e-9;
        weights /= dot(weights, vec4(1.0));
        near = split_weighted(ray, low, weights);
        far = split_weighted(ray, high, weights);
    }
    return split_between(near, far, share);
}
