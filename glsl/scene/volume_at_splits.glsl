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
    vec2 texel;  // the rays lie at integers
    vec4 reach;  // view_z [m] where the four around it end: upper left, upper right, lower right, lower left
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

// Where between the four rays around a pixel a filter of two by two reads, 0..1, so that it meets none that ends short
// of a depth: on the side, or at the corner, that is left and weighs most. All four are read where none is left.
//   place     where the pixel is
//   short_of  as SplitRay::reach
vec2 away_from_short(vec2 place, bvec4 short_of)
{
    vec4 reaches = vec4(not(short_of));  // upper left, upper right, lower right, lower left
    vec2 low = 1.0 - place;
    vec4 weights = vec4(low.x * place.y, place.x * place.y, place.x * low.y, low.x * low.y);
    // What the left, the right, the lower and the upper side weigh, where both of their rays reach.
    vec4 sides = vec4(low.x, place.x, low.y, place.y) * (reaches.xyzx * reaches.wzwy);
    vec4 corners = reaches * (weights + 1e-6);
    float side = max(max(sides.x, sides.y), max(sides.z, sides.w));
    float corner = max(max(corners.x, corners.y), max(corners.z, corners.w));
    vec2 on_side = side == sides.x   ? vec2(0.0, place.y)
                   : side == sides.y ? vec2(1.0, place.y)
                   : side == sides.z ? vec2(place.x, 0.0)
                                     : vec2(place.x, 1.0);
    vec2 at_corner = vec2(corner == corners.y || corner == corners.z, corner == corners.x || corner == corners.y);
    vec2 moved = side > 0.0 ? on_side : at_corner;
    return any(short_of) && corner > 0.0 ? moved : place;
}

VolumeAt split_bilinear(vec2 texel, int k)
{
    vec3 uv = vec3((texel + 0.5) * u_frame.inverse_layer_size, float(k));
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
    vec3 transmittance =
        near.transmittance * pow(clamp(far.transmittance / max(near.transmittance, kLeast), kLeast, 1.0), vec3(share));
    vec3 scattered =
        mix((near.transmittance - transmittance) / max(dims, kThin), vec3(share), lessThan(dims, vec3(kThin)));
    return VolumeAt(mix(near.scattering, far.scattering, scattered), transmittance);
}

// Where in a smaller layer a ray's look-up before a depth reads.
vec2 split_place(SplitRay ray, float view_z)
{
    // A ray that ends before this depth, at a surface, knows nothing of what lies there.
    bvec4 short_of = lessThan(ray.reach, vec4(min(view_z, u_frame.media_range.y)));
    vec2 corner = floor(ray.texel);
    return corner + away_from_short(ray.texel - corner, short_of);
}

// Before a pane, of those at whose depths the march kept what it met.
VolumeAt volume_at_pane(SplitRay ray, int k, float view_z)
{
    if (kLayerScale == 1)
        return split_texel(ivec2(round(ray.texel)), k);
    return split_bilinear(split_place(ray, view_z), k);
}

VolumeAt volume_at(SplitRay ray, float view_z)
{
    // The four depths that it lies among, and the next, by those that fours begin with, which are all compared: a search
    // would gather each of its depths.
    const float kBeyond = 3e38;
    vec4 z = u_splits.view_z[0];
    float next = kBeyond;
    int low = -1;
    for (int i = 1; i < kSplitFours; ++i) {
        vec4 four = u_splits.view_z[i];
        bool is_before = four.x <= view_z;
        z = is_before ? four : z;
        low = is_before ? 4 * i - 1 : low;
        next = is_before ? next : min(next, four.x);
    }
    bvec4 are_before = lessThanEqual(z, vec4(view_z));
    low += int(dot(vec4(are_before), vec4(1.0)));
    float begin = are_before.w ? z.w : are_before.z ? z.z : are_before.y ? z.y : z.x;
    float end = !are_before.x ? z.x : !are_before.y ? z.y : !are_before.z ? z.z : !are_before.w ? z.w : next;
    low = clamp(low, 0, u_splits.count - 1);
    int high = min(low + 1, u_splits.count - 1);
    float share = clamp((view_z - begin) / max(end - begin, 1e-30), 0.0, 1.0);

    VolumeAt near, far;
    if (kLayerScale == 1) {
        ivec2 texel = ivec2(round(ray.texel));
        near = split_texel(texel, low);
        far = split_texel(texel, high);
    } else {
        vec2 texel = split_place(ray, view_z);
        near = split_bilinear(texel, low);
        far = split_bilinear(texel, high);
    }
    return split_between(near, far, share);
}
