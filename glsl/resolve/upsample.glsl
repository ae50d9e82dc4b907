// Brings the volume layer to the scene's resolution, minding its depth, to be blended over the picture:
// transmittance by multiplication and scattering by addition, both targets at once or one after the other.
//   in   a layer target or two, the layer's depth and the host's
//   out  the targets' values at this pixel
#include "lib/depth.glsl"
#include "scene/frame.glsl"

// Variant, besides BOTH
const int kUpsampleTaps = 4;  // 4: a tent over 4x4 texels; 2: bilinear over 2x2; 1: copies the texel (scale 1)
const bool kBox2017 = false;  // 4x4 texels with equal weights, depth compared in metres, one side half a texel off

layout(binding = SCENE_DEPTH_UNIT) uniform sampler2D u_scene_depth_tx;
layout(binding = LAYER_DEPTH_UNIT) uniform sampler2D u_layer_depth_tx;
layout(binding = SCATTERING_UNIT) uniform sampler2D u_layer_tx;
layout(binding = TRANSMITTANCE_UNIT) uniform sampler2D u_transmittance_tx;
#include "resolve/resolved.glsl"

struct Texel {
    vec4 color;
    vec3 transmittance;  // kBoth
    float weight;
};

void add(inout Texel sum, ivec2 texel, float weight)
{
    sum.color += weight * texelFetch(u_layer_tx, texel, 0);
    if (kBoth)
        sum.transmittance += weight * texelFetch(u_transmittance_tx, texel, 0).rgb;
    sum.weight += weight;
}

// Depths before and behind all media see the same of them.
float media_view_z(float view_z) { return clamp(view_z, u_frame.media_range.x, u_frame.media_range.y); }

void add_box_2017(inout Texel sum, ivec2 pixel, float scene_z)
{
    ivec2 last = textureSize(u_layer_depth_tx, 0) - 1;
    ivec2 first = pixel / kLayerScale - 1;
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x) {
            ivec2 texel = clamp(first + ivec2(x, y), ivec2(0), last);
            float layer_z = texelFetch(u_layer_depth_tx, texel, 0).r;
            add(sum, texel, abs(layer_z - scene_z) < u_frame.depth_threshold ? 1.0 : 0.0);
        }
    if (sum.weight == 0.0)
        add(sum, clamp(first, ivec2(0), last), 1.0);
}

// Of texel i of 4x4, the first of which is given.
ivec2 tent_texel(ivec2 first, int i) { return first + ivec2(i & 3, i >> 2); }

float tent_weight(ivec2 texel, vec2 position)
{
    vec2 tent = max(1.0 - 0.5 * abs(vec2(texel) - position), 0.0);
    return tent.x * tent.y;
}

// weight: what it has by its place
void add_by_depth(inout Texel sum, ivec2 texel, float weight, float scene_z, float tolerance)
{
    float layer_z = media_view_z(texelFetch(u_layer_depth_tx, texel, 0).r);
    add(sum, texel, weight * same_depth(layer_z, scene_z, tolerance));
}

// position: in texels; the layer's samples lie at integers. tolerance: of depth [m]
void add_tent(inout Texel sum, vec2 position, float scene_z, float tolerance)
{
    ivec2 last = textureSize(u_layer_depth_tx, 0) - 1;
    ivec2 first = ivec2(floor(position)) - 1;
    for (int i = 0; i < 16; ++i) {
        ivec2 texel = tent_texel(first, i);
        add_by_depth(sum, clamp(texel, ivec2(0), last), tent_weight(texel, position), scene_z, tolerance);
    }
}

// least: of the sum's weight, or the texels around have a part in it too
void add_bilinear(inout Texel sum, vec2 position, float scene_z, float tolerance, float least)
{
    ivec2 size = textureSize(u_layer_depth_tx, 0);
    ivec2 last = size - 1;
    ivec2 first = ivec2(floor(position));
    vec2 high = position - vec2(first);
    vec2 low = 1.0 - high;
    // One fetch for four depths, in its order: upper left, upper right, lower right, lower left.
    vec4 layer_z = textureGather(u_layer_depth_tx, (vec2(first) + 1.0) * (1.0 / vec2(size)));
    layer_z = clamp(layer_z, vec4(u_frame.media_range.x), vec4(u_frame.media_range.y));
    vec3 weights = vec3(low.x * high.y, high.x * high.y, high.x * low.y) * same_depth(layer_z, scene_z, tolerance).xyz;
    ivec2 upper_right = min(first + 1, last);
    ivec2 lower_left = max(first, ivec2(0));
    add(sum, ivec2(lower_left.x, upper_right.y), weights.x);
    add(sum, upper_right, weights.y);
    add(sum, ivec2(upper_right.x, lower_left.y), weights.z);
    // The fourth is the first turn of the loop over those around: llvmpipe runs a loop's body once for all pixels, whether
    // any of them needs it or not.
    ivec2 texel = lower_left;
    float weight = low.x * low.y;
    int turn = 0;
    bool more;
    do {
        add_by_depth(sum, texel, weight, scene_z, tolerance);
        ivec2 next = tent_texel(first - 1, turn);
        weight = tent_weight(next, position);
        texel = clamp(next, ivec2(0), last);
        more = turn == 0 ? sum.weight < least : turn < 16;
        ++turn;
    } while (more);
}

void add_texels(inout Texel sum, ivec2 pixel)
{
    if (kUpsampleTaps == 1) {
        add(sum, pixel, 1.0);
        return;
    }
    float scene_z = view_z_of(texelFetch(u_scene_depth_tx, pixel, 0).r, u_frame.view_z_from_depth, u_frame.sky_depth);
    if (kBox2017) {
        add_box_2017(sum, pixel, scene_z);
        return;
    }
    scene_z = media_view_z(scene_z);
    float reach = u_frame.media_depth > 0.0 ? u_frame.media_depth : scene_z;
    float tolerance = u_frame.depth_threshold * reach;
    vec2 position = (vec2(pixel) + 0.5) / float(kLayerScale) - 0.5 - u_frame.layer_offset;
    if (kUpsampleTaps == 4) {
        add_tent(sum, position, scene_z, tolerance);
        return;
    }
    // A pixel amid foliage may have no texel of its own depth among four, and has one among those around. One that
    // is of it weighs 1/16 at least at half the picture's size, 1/64 at a quarter of it.
    const float kNone = 0.25 / float(4 * kLayerScale * kLayerScale);
    add_bilinear(sum, position, scene_z, tolerance, kNone);
}

Resolved upsampled(ivec2 pixel)
{
    Texel sum = Texel(vec4(0.0), vec3(0.0), 0.0);
    add_texels(sum, pixel);
    return Resolved(sum.color / sum.weight, sum.transmittance / sum.weight);
}
