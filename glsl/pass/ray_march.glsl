// The ray march: what the media do to each pixel of the volume layer, between the eye and the scene's
// depth. Eevee's design of July 2017.
//   in   the layer's depth (view_z [m]), the scene's media and lights, blue noise
//   out  scattering     radiance scattered and emitted towards the eye [W/m^2/sr]
//        transmittance  per channel, 0..1
//        or, kMonochrome, one target: scattering in rgb, mean transmittance in alpha
//        media depth    kMediaDepth: where what the ray sees of the media lies, mean and standard deviation, as
//                       fractions of their range of view depth; -1: there are none on its way. In the alphas,
//                       or, kMonochrome, in the second target
//        split layers   kSplits: the same two at the frame's depths (scene/split_depths.glsl), in tiles that ask for it
#include "lib/channels.glsl"
#include "lib/step_lattice.glsl"
#include "shared/step_tile.h"
#include "scene/in_scattering.glsl"
#include "scene/split_store.glsl"

// Variant, besides kCountSamples: write the number of media evaluations instead
const bool kBlueNoise = false;    // sample each step at an offset of its own per pixel, else at its middle
const bool kCameraRange = false;  // march from near to far and past the scene's depth as 2017 did, sampling the end of
                                  // each step; else only where media are, each step cut exactly at both ends
const bool kMonochrome = false;
const bool kSplits = false;
const bool kMediaDepth = false;  // work out a depth that stands for the ray's media, for march_history.glsl

layout(binding = LAYER_DEPTH_UNIT) uniform sampler2D u_layer_depth_tx;
layout(binding = BLUE_NOISE_UNIT) uniform sampler2D u_blue_noise_tx;

extinction_t light_depth(int i, vec3 p, LightSample light) { return dimming_to_light(i, p, light); }

// Sums of weights, x, of weights times view depth from the nearest, y, and times its square, z. What is seen
// of a medium is the light that comes from it, or, where none does, that it hides what is behind.
struct MediaDepth {
    float nearest;
    vec3 shining, hiding;
};

vec2 media_depth_of(MediaDepth sums, float farthest)
{
    if (!(sums.nearest < farthest))
        return vec2(-1.0, 0.0);
    vec3 sum = sums.shining.x > 0.0 ? sums.shining : sums.hiding;
    float most = farthest - sums.nearest;
    float mean = sum.y / sum.x;
    float spread = sqrt(max(sum.z / sum.x - mean * mean, 0.0));
    if (!(mean >= 0.0 && mean <= most && spread <= most)) {  // nothing was seen, or too much
        mean = 0.5 * most;
        spread = 0.0;
    }
    return vec2(sums.nearest - u_frame.media_range.x + mean, spread) /
           max(u_frame.media_range.y - u_frame.media_range.x, 1e-30);
}

// A step that is uniform, and what the ray has met before it.
struct SplitStep {
    vec2 range;  // view_z [m]
    vec3 source, scattering;
    extinction_t sigma_t, transmittance;
};

// What a ray has met so far.
struct Layer {
    vec3 scattering;
    extinction_t transmittance;
    float straight_on;  // kAureole: optical depth of what is scattered straight on
    MediaDepth seen;
    ivec2 texel;
    SplitWalk splits;
    SplitStep last;  // kSplits
};

bool has_split(Layer layer) { return kSplits && layer.splits.view_z < layer.last.range.y; }

// Keeps what a ray has met at the depths before its last step's end.
void keep_splits(inout Layer layer, float length_per_z)
{
    SplitStep last = layer.last;
    if (has_split(layer))
        do {
            float ds = max(layer.splits.view_z - last.range.x, 0.0) * length_per_z;
            extinction_t tau = last.sigma_t * ds;
            vec3 scattering = last.scattering + last.transmittance * last.source * (ds * slab_weight(tau));
            extinction_t transmittance = last.transmittance * exp(-tau);
            ivec3 at = ivec3(layer.texel, layer.splits.next);
            imageStore(u_split_scattering_img, at,
                       vec4(min(scattering, vec3(u_frame.radiance_limit)), mean(transmittance)));
            if (!kMonochrome)
                imageStore(u_split_transmittance_img, at, vec4(vec3(transmittance), 1.0));
            step_on(layer.splits);
        } while (has_split(layer));
}

// From step.x to step.y, sampled at `share` of it, z.
void march(inout Layer layer, MediaLine line, LightLine light, float length_per_z, vec2 step, float share, float z)
{
    float ds = (step.y - step.x) * length_per_z;
    MediumSample medium = sample_media(point_on(line, z));
    vec3 source = medium.emission;
    extinction_t tau = medium.sigma_t * ds;
    float z_lit = kExactFalloff ? z - (step.y - step.x) * light_ahead(mean(tau)) : z;
    float straight_on = 0.0;
    if (kAureole) {
        float g2 = light.peak_g * light.peak_g;
        float sigma_s = min(medium.sigma_s.r, min(medium.sigma_s.g, medium.sigma_s.b));
        straight_on = g2 * g2 * sigma_s * peaked_share(light, medium.g) * ds;
    }
    if (medium.sigma_s != vec3(0.0))
        source += medium.sigma_s * in_scattering_on(light, LightStep(z_lit, step, share, medium.g, medium.sigma_t,
                                                                     layer.straight_on + share * straight_on));
    layer.straight_on += straight_on;
    if (kSplits)
        layer.last = SplitStep(step, source, layer.scattering, medium.sigma_t, layer.transmittance);
    vec3 added = layer.transmittance * source * (ds * slab_weight(tau));
    layer.scattering += added;
    if (kMediaDepth) {
        float from_nearest = 0.5 * (step.x + step.y) - layer.seen.nearest;
        vec3 powers = vec3(1.0, from_nearest, from_nearest * from_nearest);
        layer.seen.shining += most(added) * powers;
        layer.seen.hiding += most(layer.transmittance * (1.0 - exp(-tau))) * powers;
    }
    layer.transmittance *= exp(-tau);
}

void march_camera_range(inout Layer layer, MediaLine line, LightLine light, float length_per_z, vec2 inside,
                        float offset)
{
    int steps = int(u_frame.steps);
    float z = inside.x;
    for (int i = 0; i < steps && z < inside.y; ++i) {
        float z_next = step_split((float(i) + 0.5 + offset) / float(steps), u_frame.step_range, u_frame.step_octaves,
                                  u_frame.distribution);
        march(layer, line, light, length_per_z, vec2(z, z_next), 1.0, z_next);
        keep_splits(layer, length_per_z);
        z = z_next;
    }
}

void march_tile(inout Layer layer, uvec4 tile, MediaLine line, LightLine light, float length_per_z, vec2 inside,
                float offset)
{
    int steps = int(u_frame.steps);
    float lambda = u_frame.distribution;
    vec2 range = u_frame.step_range;
    float octaves = u_frame.step_octaves;
    float enough = u_frame.min_transmittance;
    uint slots = inside.x < inside.y ? tile.x : 0u;
    int entry = step_at(inside.x, steps, range, octaves, lambda);
    entry &= -tile_stride(tile.y, tile.z, tile.w, entry);
    // Row by row of slots that hold something. Steps stay where they are whether some are left out or not.
    // llvmpipe runs a while loop's body once more with all lanes masked; do-while avoids it.
    if (slots != 0u)
        do {
            int slot = findLSB(slots);
            int beyond = slot + findLSB(~(slots >> uint(slot)));
            slots &= ~0u << uint(beyond);
            int first = max(tile_first_split(tile.w) + (slot << tile_log2_width(tile.w)), entry);
            int last = min(tile_first_split(tile.w) + (beyond << tile_log2_width(tile.w)), steps);
            float z = max(step_split(float(first) / float(steps), range, octaves, lambda), inside.x);
            int i = first;
            // Steps before whose end a depth is kept end the inner loop, and stretches do: on llvmpipe, whose lanes are
            // rays, a branch in the body takes its time whether it is taken or not.
            if (i < last && z < inside.y && most(layer.transmittance) > enough)
                do {
                    PartStretch stretch = PartStretch(1e30, 1e30);
                    if (kPartSteps)
                        stretch = part_stretch(line.ray.origin, line.ray.direction, z);
                    do {
                        int stride = tile_stride(tile.y, tile.z, tile.w, i);
                        float z_next =
                            min(step_split(float(i + stride) / float(steps), range, octaves, lambda), inside.y);
                        if (i + stride >= steps)
                            z_next = inside.y;  // rounding must not leave a rest
                        float z_end = z_next;
                        if (kPartSteps)
                            z_next = part_step(stretch, z, z_end);
                        // Where steps are long, since the medium is smooth, every other one is sampled as far from its end as
                        // the one before was from its begin: what grows evenly along the ray then has no noise. Detail is
                        // better met at even distances.
                        float share = stride == 1 || (i & stride) == 0 ? offset : 1.0 - offset;
                        march(layer, line, light, length_per_z, vec2(z, z_next), share, mix(z, z_next, share));
                        z = z_next;
                        if (!kPartSteps || z >= z_end)
                            i += stride;
                    } while (!has_split(layer) && (!kPartSteps || z < stretch.end) && i < last && z < inside.y &&
                             most(layer.transmittance) > enough);
                    keep_splits(layer, length_per_z);
                } while (i < last && z < inside.y && most(layer.transmittance) > enough);
        } while (slots != 0u);
}

// What a texel's two targets hold.
struct Marched {
    vec4 scattering, transmittance;
};

// tile: shared/step_tile.h
Marched march_texel(ivec2 texel, uvec4 tile)
{
    vec2 pixel = (vec2(texel) + 0.5 + u_frame.layer_offset) * float(kLayerScale);
    vec2 ndc = pixel * u_frame.inverse_full_size * 2.0 - 1.0;
    Ray ray = camera_ray(ndc);
    float length_per_z = length(ray.direction);
    vec3 wo = -ray.direction / length_per_z;
    float scene_z = texelFetch(u_layer_depth_tx, texel, 0).r;
    float offset = 0.5;
    if (kBlueNoise)
        offset = fract(texelFetch(u_blue_noise_tx, texel & (BLUE_NOISE_SIZE - 1), 0).r + u_frame.step_jitter);

    // A pixel's ray is its middle's; a larger texel's stands for the pixels around as well.
    float texel_ndc = 2.0 * sqrt(float(kLayerScale * kLayerScale - 1)) * u_frame.inverse_full_size.x;
    LightLine light =
        light_line(ray, wo, texel_ndc * vec2(length(u_frame.ray_origin_dx.xyz), length(u_frame.ray_direction_dx.xyz)));
    MediaLine line = media_line(ray);
    vec2 inside = vec2(u_frame.step_range.x, scene_z);
    if (!kCameraRange)
        inside = media_segment(ray.origin, ray.direction, u_frame.media_range.x, min(scene_z, u_frame.media_range.y));
    g_shaded_points = tile_shaded_points(tile.w);
    Layer layer = Layer(vec3(0.0), extinction_t(1.0), 0.0, MediaDepth(inside.x, vec3(0.0), vec3(0.0)), texel,
                        split_walk(ndc, kSplits && tile_keeps_depths(tile.w)),
                        SplitStep(vec2(0.0), vec3(0.0), vec3(0.0), extinction_t(0.0), extinction_t(1.0)));
    if (kCameraRange)
        march_camera_range(layer, line, light, length_per_z, inside, offset);
    else
        march_tile(layer, tile, line, light, length_per_z, inside, offset);
    if (kSplits)
        layer.last = SplitStep(vec2(u_frame.media_range.y, 1e38), vec3(0.0), layer.scattering, extinction_t(0.0),
                               layer.transmittance);
    keep_splits(layer, 0.0);

    vec2 media_depth = kMediaDepth ? media_depth_of(layer.seen, inside.y) : vec2(1.0);
    vec3 scattering = min(layer.scattering, vec3(u_frame.radiance_limit));  // an infinity would spoil its neighbours
    Marched marched;
    marched.scattering = vec4(scattering, kMonochrome ? mean(layer.transmittance) : media_depth.x);
    marched.transmittance = kMonochrome ? vec4(media_depth, 0.0, 1.0) : vec4(vec3(layer.transmittance), media_depth.y);
    if (kCountSamples)
        marched.scattering = vec4(float(g_samples));
    return marched;
}
