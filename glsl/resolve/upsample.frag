// Brings the volume layer to the scene's resolution, minding its depth, to be blended over the picture:
// transmittance by multiplication and scattering by addition, both targets at once or one after the other.
//   in   a layer target or two, the layer's depth and the host's
//   out  the targets' values at this pixel
//
// Variant:
//   LAYER_SCALE        pixels along a texel's edge: 1, 2 or 4
//   UPSAMPLE_TAPS      4: a tent over 4x4 texels; 2: bilinear over 2x2; 1: copies the texel (scale 1)
//   BOTH               scattering, and transmittance as the second source of blending; else one target
//   BOX_2017           4x4 texels with equal weights, depth compared in metres, one side half a texel off
#include "lib/depth.glsl"
#include "scene/frame.glsl"

layout(binding = SCENE_DEPTH_UNIT) uniform sampler2D u_scene_depth_tx;
layout(binding = LAYER_DEPTH_UNIT) uniform sampler2D u_layer_depth_tx;
layout(binding = SCATTERING_UNIT) uniform sampler2D u_layer_tx;
#ifdef BOTH
layout(binding = TRANSMITTANCE_UNIT) uniform sampler2D u_transmittance_tx;
layout(location = 0, index = 0) out vec4 out_color;
layout(location = 0, index = 1) out vec4 out_transmittance;
#else
layout(location = 0) out vec4 out_color;
#endif

struct Texel {
    vec4 color;
#ifdef BOTH
    vec3 transmittance;
#endif
};

void add(inout Texel sum, ivec2 texel, float weight)
{
    sum.color += weight * texelFetch(u_layer_tx, texel, 0);
#ifdef BOTH
    sum.transmittance += weight * texelFetch(u_transmittance_tx, texel, 0).rgb;
#endif
}

void write(Texel sum, float weight)
{
    out_color = sum.color / weight;
#ifdef BOTH
    out_transmittance = vec4(sum.transmittance / weight, 1.0);
#endif
}

// Depths before and behind all media see the same of them.
float media_view_z(float view_z)
{
    return clamp(view_z, u_frame.media_range.x, u_frame.media_range.y);
}

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
#ifdef BOTH
    Texel sum = Texel(vec4(0.0), vec3(0.0));
#else
    Texel sum = Texel(vec4(0.0));
#endif
#if UPSAMPLE_TAPS == 1
    add(sum, pixel, 1.0);
    write(sum, 1.0);
#else
    float threshold = u_frame.depth_threshold;
    float scene_z = view_z_of(texelFetch(u_scene_depth_tx, pixel, 0).r, u_frame.view_z_from_depth,
                              u_frame.sky_depth);
    ivec2 last = ivec2(u_frame.layer_size) - 1;
    float weight_sum = 0.0;
#ifdef BOX_2017
    ivec2 first = pixel / LAYER_SCALE - 1;
    for (int y = 0; y < 4; ++y) {
        for (int x = 0; x < 4; ++x) {
            ivec2 texel = clamp(first + ivec2(x, y), ivec2(0), last);
            float layer_z = texelFetch(u_layer_depth_tx, texel, 0).r;
            float weight = abs(layer_z - scene_z) < threshold ? 1.0 : 0.0;
            add(sum, texel, weight);
            weight_sum += weight;
        }
    }
    if (weight_sum == 0.0) {
        add(sum, clamp(first, ivec2(0), last), 1.0);
        weight_sum = 1.0;
    }
#else
    scene_z = media_view_z(scene_z);
    float reach = u_frame.media_depth > 0.0 ? u_frame.media_depth : scene_z;
    // In texels; the layer's samples lie at integers.
    vec2 position = gl_FragCoord.xy / float(LAYER_SCALE) - 0.5 - u_frame.layer_offset;
    ivec2 first = ivec2(floor(position)) - (UPSAMPLE_TAPS / 2 - 1);
#if UPSAMPLE_TAPS == 2
    vec2 high = position - vec2(first);
    vec2 low = 1.0 - high;
    // One fetch for four depths, in its order: upper left, upper right, lower right, lower left.
    vec4 layer_z = textureGather(u_layer_depth_tx, (vec2(first) + 1.0) * u_frame.inverse_layer_size);
    layer_z = clamp(layer_z, vec4(u_frame.media_range.x), vec4(u_frame.media_range.y));
    vec4 weights = vec4(low.x * high.y, high.x * high.y, high.x * low.y, low.x * low.y) *
                   same_depth(layer_z, scene_z, threshold * reach);
    ivec2 upper_right = min(first + 1, last);
    ivec2 lower_left = max(first, ivec2(0));
    add(sum, ivec2(lower_left.x, upper_right.y), weights.x);
    add(sum, upper_right, weights.y);
    add(sum, ivec2(upper_right.x, lower_left.y), weights.z);
    add(sum, lower_left, weights.w);
    weight_sum = weights.x + weights.y + weights.z + weights.w;
#else
    for (int y = 0; y < UPSAMPLE_TAPS; ++y) {
        for (int x = 0; x < UPSAMPLE_TAPS; ++x) {
            ivec2 texel = first + ivec2(x, y);
            vec2 tent = max(1.0 - abs(vec2(texel) - position) / float(UPSAMPLE_TAPS / 2), 0.0);
            texel = clamp(texel, ivec2(0), last);
            float layer_z = media_view_z(texelFetch(u_layer_depth_tx, texel, 0).r);
            float weight = tent.x * tent.y * same_depth(layer_z, scene_z, threshold * reach);
            add(sum, texel, weight);
            weight_sum += weight;
        }
    }
#endif
#endif
    write(sum, weight_sum);
#endif
}
