// The march's history: what the frames before have gathered of a texel's ray, moved towards this frame's.
//   in   this frame's march and its layer's depth; what is kept of last frame
//   out  kept       scattering in rgb; kMonochrome: transmittance in alpha, else `frames`
//        kept_more  transmittance in rgb, the scene's depth in alpha; kMonochrome: `frames` and that depth
// `frames` is how many frames of its own a texel's mean is worth: one that was hidden, or out of view,
// begins at 1 while those around it go on. The scene's depth is a fraction of the media's range (-1: no
// medium is in this ray's way, whatever its depth): what was gathered in front of another surface is not
// this ray's. A ray's media stand for one point of it, the mean of what it sees of them (ray_march.glsl).
// How much of what was gathered is kept is decided as by a Kalman filter (Kalman 1960): by what moving it has lost
// beside the noise that a frame has.
#include "lib/channels.glsl"
#include "lib/depth.glsl"
#include "scene/frame.glsl"
#include "shared/march_history_params.h"

// Variant. HISTORY_MOVED: last frame's rays are not these, one for one, so the scene's media and lights are needed.
#ifdef HISTORY_MOVED
#include "scene/in_scattering.glsl"
#include "scene/turned_to_eye.glsl"
extinction_t light_depth(int i, vec3 p, LightSample light) { return extinction_t(0.0); }
const bool kMoved = true;
#else
const bool kMoved = false;
#endif
const bool kHistory = false;       // last frame's layer is there
const bool kLightChanged = false;  // the scene is not last frame's;
const bool kMediaChanged = false;  // what its media dim is another too

layout(binding = LAYER_DEPTH_UNIT) uniform sampler2D u_layer_depth_tx;
layout(binding = SCATTERING_UNIT) uniform sampler2D u_scattering_tx;
layout(binding = TRANSMITTANCE_UNIT) uniform sampler2D u_more_tx;  // kMonochrome: the media's depth
layout(std140, binding = MARCH_HISTORY_BLOCK) uniform MarchHistory { MarchHistoryParams u_history; };
layout(binding = KEPT_UNIT) uniform sampler2D u_kept_tx;
layout(binding = KEPT_MORE_UNIT) uniform sampler2D u_kept_more_tx;

#ifdef MONOCHROME
#define transmittance_t float
const bool kMonochrome = true;
float transmittance_of(vec4 scattering, vec4 more) { return scattering.a; }
#else
#define transmittance_t vec3
const bool kMonochrome = false;
vec3 transmittance_of(vec4 scattering, vec4 more) { return more.rgb; }
#endif

// What a ray sees of the media.
struct Sight {
    vec3 scattering;
    transmittance_t transmittance;
};

float square(vec3 v) { return dot(v, v); }
float square(float v) { return v * v; }

void add(inout Sight sum, float weight, Sight sight)
{
    sum.scattering += weight * sight.scattering;
    sum.transmittance += weight * sight.transmittance;
}

// Of a difference: the square of what it does to a picture whose light is `source`, the media's own.
float square_of(Sight difference, float source)
{
    return square(difference.scattering) + source * source * square(difference.transmittance);
}

const Sight kNoSight = Sight(vec3(0.0), transmittance_t(0.0));

struct Kept {
    Sight sight;
    float frames;
    float depth;  // of the scene, as a fraction
};

Sight sight_at(ivec2 texel)
{
    vec4 scattering = texelFetch(u_scattering_tx, texel, 0);
    return Sight(scattering.rgb, transmittance_of(scattering, texelFetch(u_more_tx, texel, 0)));
}

// Of the media: mean and standard deviation, as fractions; -1: there are none.
vec2 media_depth_at(ivec2 texel)
{
    vec4 more = texelFetch(u_more_tx, texel, 0);
    return kMonochrome ? more.rg : vec2(texelFetch(u_scattering_tx, texel, 0).a, more.a);
}

// view_z where a ray ends; before and behind all media it sees the same of them.
float scene_z_at(ivec2 texel)
{
    return clamp(texelFetch(u_layer_depth_tx, texel, 0).r, u_frame.media_range.x, u_frame.media_range.y);
}

// Neither NaN nor infinite: those would live on in what is kept.
bool is_sound(Sight sight)
{
    const float kMost = 3e38;
    return all(lessThan(abs(sight.scattering), vec3(kMost))) &&
           all(lessThan(abs(vec3(sight.transmittance)), vec3(kMost)));
}

Kept kept_at(ivec2 texel)
{
    vec4 kept = texelFetch(u_kept_tx, texel, 0);
    vec4 more = texelFetch(u_kept_more_tx, texel, 0);
    Sight sight = Sight(kept.rgb, transmittance_of(kept, more));
    return kMonochrome ? Kept(sight, more.x, more.y) : Kept(sight, kept.a, more.a);
}

// Of a texel of last frame, 0..1: how far it ended where a ray ends that ends at view_z.
float match_of(Kept kept, float view_z)
{
    if (!(kept.frames > 0.0) || !is_sound(kept.sight))
        return 0.0;
    if (kept.depth < 0.0)
        return 1.0;
    vec2 range = u_history.media_range;
    view_z = clamp(view_z, range.x, range.y);
    float reach = u_history.media_depth > 0.0 ? u_history.media_depth : view_z;
    return same_depth(mix(range.x, range.y, kept.depth), view_z, u_frame.depth_threshold * reach);
}

// What is kept of a ray.
struct Reprojected {
    Kept kept;
    vec2 position;      // where last frame's layer has it, in texels
    float old_scene_z;  // where that ray ended
    // Of HISTORY_MOVED, where all texels around that place are the ray's:
    bool whole;
    Sight broad;           // the mean over more than a texel
    Sight between, moved;  // what is lost between texels, and as its media move against themselves
    float turn;            // by how much it is seen from elsewhere, the angle's sine
};

Reprojected no_history(vec2 position, float scene_z)
{
    return Reprojected(Kept(kNoSight, 0.0, 0.0), position, scene_z, false, kNoSight, kNoSight, kNoSight, 0.0);
}

#ifdef HISTORY_MOVED
Sight filtered(vec2 uv)
{
    vec4 scattering = textureLod(u_kept_tx, uv, 0.0);
    return Sight(scattering.rgb, transmittance_of(scattering, textureLod(u_kept_more_tx, uv, 0.0)));
}

void add(inout Sight sum, float weight, vec2 position)
{
    add(sum, weight, filtered((position + 0.5) * u_frame.inverse_layer_size));
}

// The mean over a texel and half of those around it.
Sight broad(vec2 position)
{
    Sight sum = kNoSight;
    for (int i = 0; i < 4; ++i)
        add(sum, 0.25, position + vec2(i & 1, i >> 1) - 0.5);
    return sum;
}

// Between texels by Catmull and Rom's cubic, in 5 bilinear fetches as Jimenez 2016 has it: its 16 texels but
// for the corners. Frame after frame, a bilinear mean would blur what it keeps.
Sight sharp(vec2 position)
{
    vec2 first = floor(position);
    vec2 f = position - first;
    vec2 w0 = f * (-0.5 + f * (1.0 - 0.5 * f));
    vec2 w1 = 1.0 + f * f * (-2.5 + 1.5 * f);
    vec2 w3 = f * f * (-0.5 + 0.5 * f);
    vec2 w12 = 1.0 - w0 - w3;
    vec2 middle = first + (w12 - w1) / w12;
    vec2 before = first - 1.0, behind = first + 2.0;
    vec4 sides = vec4(w0 * w12.yx, w3 * w12.yx);
    float sum = w12.x * w12.y + sides.x + sides.y + sides.z + sides.w;
    Sight sight = kNoSight;
    add(sight, w12.x * w12.y / sum, middle);
    add(sight, sides.x / sum, vec2(before.x, middle.y));
    add(sight, sides.y / sum, vec2(middle.x, before.y));
    add(sight, sides.z / sum, vec2(behind.x, middle.y));
    add(sight, sides.w / sum, vec2(middle.x, behind.y));
    return sight;
}

// Of the media at p; where they have one g and no glow of their own, what there is of them cancels out.
vec3 turned(vec3 p, vec3 wo)
{
    MediumSample medium = MediumSample(vec3(1.0), extinction_t(0.0), vec3(0.0), u_media.media[0].g);
    if (kMixedG || kEmission)
        medium = sample_media(p);
    return turned_to_eye(p, wo, u_history.eye, medium.sigma_s, medium.emission, medium.g);
}

// Where last frame's layer has a point, in texels; the layer's samples lie at integers.
vec2 old_position(vec3 p)
{
    vec4 clip = u_history.clip_from_world * vec4(p, 1.0);
    if (!(clip.w > 0.0))
        return vec2(-2.0);  // out of it
    vec2 position =
        (clip.xy / clip.w * 0.5 + 0.5) * u_frame.full_size / float(kLayerScale) - 0.5 - u_history.layer_offset;
    return clamp(position, vec2(-2.0), u_frame.layer_size + 1.0);  // or no integer has it
}

Reprojected history_of(ivec2 texel, vec2 media_depth, float scene_z)
{
    Reprojected last = no_history(vec2(-2.0), scene_z);
    vec2 pixel = (vec2(texel) + 0.5 + u_frame.layer_offset) * float(kLayerScale);
    Ray ray = camera_ray(pixel * u_frame.inverse_full_size * 2.0 - 1.0);
    if (media_depth.x < 0.0)
        return last;
    vec2 view_z = u_frame.media_range.x +
                  (u_frame.media_range.y - u_frame.media_range.x) * (media_depth.x + media_depth.y * vec2(-1.0, 1.0));
    vec3 p = ray.origin + ray.direction * (0.5 * (view_z.x + view_z.y));
    last.old_scene_z = dot(u_history.view_z_from_world, vec4(ray.origin + ray.direction * scene_z, 1.0));
    last.position = old_position(p);
    ivec2 first = ivec2(floor(last.position));
    ivec2 end = ivec2(u_frame.layer_size) - 1;
    // What lies before and behind that point comes from elsewhere, half as far as both of them lie apart.
    vec2 apart = 0.5 * (old_position(ray.origin + ray.direction * view_z.x) -
                        old_position(ray.origin + ray.direction * view_z.y));
    Sight mean = kNoSight;
    float share = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 corner = ivec2(i & 1, i >> 1);
        ivec2 at = first + corner;
        if (at != clamp(at, ivec2(0), end))
            continue;
        Kept kept = kept_at(at);
        vec2 tent = 1.0 - abs(vec2(at) - last.position);
        float weight = tent.x * tent.y * match_of(kept, last.old_scene_z);
        if (weight <= 0.0)
            continue;  // 0 times an infinity
        add(mean, weight, kept.sight);
        last.kept.frames += weight * kept.frames;
        share += weight;
        vec2 slope = (2.0 * vec2(corner) - 1.0) * tent.yx;
        add(last.moved, dot(slope, apart), kept.sight);
    }
    vec3 turned = turned(p, -normalize(ray.direction));
    const float kAll = 0.99;
    if (share > kAll) {
        last.whole = true;
        last.kept.sight = sharp(last.position);
        last.between = last.kept.sight;
        add(last.between, -1.0, mean);
        last.kept.sight.scattering *= turned;
        last.broad = broad(last.position);
        last.broad.scattering *= turned;
        vec3 old_wo = u_history.eye.w == 0.0 ? u_history.eye.xyz : normalize(u_history.eye.xyz - p);
        last.turn = length(cross(old_wo, normalize(ray.direction)));
    } else if (share > 0.0) {
        // A bilinear mean blurs: with each frame a little more.
        const float kBetween = 0.3;  // frames half way between texels
        vec2 between = fract(last.position);
        between = 2.0 * between * (1.0 - between);  // 1 half way, of both together
        last.kept.frames = min(last.kept.frames, kBetween / max(between.x + between.y, 1e-6));
        last.kept.sight = Sight(mean.scattering * turned / share, mean.transmittance / share);
    }
    return last;
}

#else
Reprojected history_of(ivec2 texel, vec2 media_depth, float scene_z)
{
    Reprojected last = no_history(vec2(texel), scene_z);
    last.kept = kept_at(texel);
    last.kept.frames *= match_of(last.kept, scene_z);
    return last;
}
#endif

// What this frame sees around a texel, before the same surface: the mean and a standard deviation.
struct Around {
    Sight mean, reach;
    // kMoved:
    Sight own;                      // the texel's
    vec2 media_depth;               // of what is seen of the media there, as media_depth_at() has it
    Sight bend_x, bend_y, bend_xy;  // second differences, and the second difference of those
    float source, noise, value;     // squares but for the source: of what a frame errs by, and of what it shows
    transmittance_t depth_noise;    // of that error of a transmittance
};

// `sight` is the texel's.
Around around(ivec2 texel, Sight sight, float scene_z)
{
    float reach = u_frame.media_depth > 0.0 ? u_frame.media_depth : scene_z;
    ivec2 last = ivec2(u_frame.layer_size) - 1;
    Sight sum = kNoSight, squares = sum, bend_x = sum, bend_y = sum, bend_xy = sum, tilt_x = sum, tilt_y = sum;
    float weights = 0.0;
    vec3 shining = vec3(0.0), hiding = vec3(0.0);
    for (int i = 0; i < 9; ++i) {
        ivec2 to = ivec2(i % 3, i / 3) - 1;
        ivec2 at = clamp(texel + to, ivec2(0), last);
        float weight = same_depth(scene_z_at(at), scene_z, u_frame.depth_threshold * reach);
        Sight near = sight_at(at);
        add(sum, weight, near);
        add(squares, weight, Sight(near.scattering * near.scattering, near.transmittance * near.transmittance));
        weights += weight;
        if (!kMoved)
            continue;
        Sight more = near;
        add(more, -1.0, sight);
        vec2 bend = vec2(3 * to * to - 2);  // 1, -2, 1
        add(bend_x, to.y == 0 ? weight * bend.x : 0.0, more);
        add(bend_y, to.x == 0 ? weight * bend.y : 0.0, more);
        add(bend_xy, weight * bend.x * bend.y, more);
        add(tilt_x, weight * float(to.x) * bend.y, more);
        add(tilt_y, weight * float(to.y) * bend.x, more);
        vec2 depth = media_depth_at(at);
        weight *= depth.x < 0.0 ? 0.0 : float((2 - abs(to.x)) * (2 - abs(to.y)));
        shining += weight * most(near.scattering) * vec3(1.0, depth);
        hiding += weight * (1.0 - mean(near.transmittance)) * vec3(1.0, depth);
    }
    vec3 s = sum.scattering / weights;
    transmittance_t t = sum.transmittance / weights;
    Around now;
    now.mean = Sight(s, t);
    now.reach = Sight(sqrt(max(squares.scattering / weights - s * s, 0.0)),
                      sqrt(max(squares.transmittance / weights - t * t, 0.0)));
    if (kMoved) {
        now.own = sight;
        // A ray that has met nothing, as few steps may, has no depth to go by: those beside it have.
        vec3 seen = shining.x > 0.0 ? shining : hiding;
        now.media_depth = seen.x > 0.0 ? seen.yz / seen.x : media_depth_at(texel);
        now.bend_x = bend_x;
        now.bend_y = bend_y;
        now.bend_xy = bend_xy;
        now.source = mean(s) / max(1.0 - mean(t), 1e-3);
        if (!(now.source > 0.0))
            now.source = 1.0;
        // A parabola has none of these three, and noise has its variance times the squares of their weights
        // (after Immerkaer 1996, whose mask is the first).
        now.noise = (square_of(bend_xy, now.source) / 36.0 +
                     (square_of(tilt_x, now.source) + square_of(tilt_y, now.source)) / 12.0) /
                    3.0;
        now.depth_noise =
            (bend_xy.transmittance * bend_xy.transmittance / 36.0 +
             (tilt_x.transmittance * tilt_x.transmittance + tilt_y.transmittance * tilt_y.transmittance) / 12.0) /
            3.0;
        now.value = square_of(Sight(s, 1.0 - t), now.source);
    }
    return now;
}

// The mean of what a frame sees around a texel, over as much as last frame's is: or it would sharpen or blur.
Sight broad_now(Around now, vec2 position)
{
    vec2 between = fract(position + 0.5);
    vec2 w = 0.125 + 0.5 * between * (1.0 - between);
    Sight mean = now.own;
    add(mean, w.x, now.bend_x);
    add(mean, w.y, now.bend_y);
    add(mean, w.x * w.y, now.bend_xy);
    // As mean_of() has it: the mean of noisy transmittances is too large, by half of their depths' variance.
    transmittance_t t = max(mean.transmittance, 0.0);
    transmittance_t deeper = min(0.5 * now.depth_noise / max(t, 1e-3), 0.25 * t);
    mean.scattering *= 1.0 + min(deeper / max(1.0 - t, 1e-3), 0.5);
    mean.transmittance -= deeper;
    return mean;
}

// What lies farther from the eye or nearer moves another way, is longer or shorter on the ray, and is lit from
// elsewhere: what was gathered is brought towards the mean of what is around now, whose noise is small, so that
// brightness does not lag behind. And once what it has lost on its way counts as noise, it is worth fewer frames.
void follow(Around now, Reprojected last, inout Kept history)
{
    // Of squares: by so much of what is seen a turn of one changes it, about.
    const float kChange = 0.3;
    float change = kChange * square(last.turn) * now.value;
    float noise = max(now.noise, 1e-30);
    // Where a change is lasting this share of it has the least error.
    const float kMost = 0.6;
    float share = min(pow(change / noise, 1.0 / 3.0), kMost);
    add(history.sight, share, broad_now(now, last.position));
    add(history.sight, -share, last.broad);
    history.sight.scattering = max(history.sight.scattering, vec3(0.0));
    // Of squares, too: what a cubic between texels errs by is about as much as it differs by from a bilinear mean, and
    // media's layers move by more than their sum shows.
    const float kBetween = 2.0, kApart = 10.0;
    float lost = kBetween * square_of(last.between, now.source) + kApart * square_of(last.moved, now.source) +
                 square(1.0 - share) * change;
    history.frames = 1.0 / (1.0 / history.frames + lost / noise);
}

// Clips what is kept to that, as Salvi 2016 has it.
void clip(Around now, bool transmittance_too, inout Sight sight)
{
    sight.scattering =
        clamp(sight.scattering, now.mean.scattering - now.reach.scattering, now.mean.scattering + now.reach.scattering);
    if (transmittance_too)
        sight.transmittance = clamp(sight.transmittance, now.mean.transmittance - now.reach.transmittance,
                                    now.mean.transmittance + now.reach.transmittance);
}

// What last frame has around a place, behind which a ray ended at old_scene_z.
Sight kept_around(vec2 position, float old_scene_z)
{
    ivec2 middle = ivec2(floor(position + 0.5)), last = ivec2(u_frame.layer_size) - 1;
    Sight sum = kNoSight;
    float weights = 1e-30;
    for (int i = 0; i < 9; ++i) {
        Kept near = kept_at(clamp(middle + ivec2(i % 3, i / 3) - 1, ivec2(0), last));
        float weight = match_of(near, old_scene_z);
        if (weight <= 0.0)
            continue;  // 0 times an infinity
        add(sum, weight, near.sight);
        weights += weight;
    }
    return Sight(sum.scattering / weights, sum.transmittance / weights);
}

// The scene is another one. What is kept is brought to the mean of what this frame sees around the texel, and is
// worth the fewer frames the less it looks like it.
void adapt(Around now, Sight before, inout Kept history)
{
    // Frames that what was gathered before a change is worth behind it, at most; and natural logarithms of a change
    // of the mean: history holds its worth up to the first, and has none from the second on. Media that move are
    // told by far less than light that does: their edges differ, and hardly their mean.
    const float kMostFrames = kMediaChanged ? 0.5 : 2.0;
    const vec2 kAlike = kMediaChanged ? vec2(0.003, 0.03) : vec2(0.05, 0.5);
    const float kMost = 4.0;
    vec3 s = now.mean.scattering, b = before.scattering;
    float dim = 1e-2 * max(max(max(s.r, b.r), max(s.g, b.g)), max(max(s.b, b.b), 1e-30));
    vec3 brighter = (s + dim) / (b + dim);
    history.sight.scattering *= clamp(brighter, 1.0 / kMost, kMost);
    vec3 change = abs(log(brighter));
    if (kMediaChanged)
        change = max(change, vec3(abs(log(max(now.mean.transmittance, 1e-3) / max(before.transmittance, 1e-3)))));
    history.frames = min(history.frames, kMostFrames) * (1.0 - smoothstep(kAlike.x, kAlike.y, most(change)));
}

// Of a frame and of what was gathered, `weight` its share. What few steps err of an optical depth is of either
// sign, so the mean of transmittances is too large: depths are averaged, unless they differ so much that the ray
// met something else, as at an edge. What a ray scatters grows with what it takes away, so it is corrected by as
// much: the mean of frames' sources stays what it is.
Sight mean_of(Sight now, Sight before, float weight)
{
    const float kClear = 1e-3;
    // By the quotient alone: exp(log()) of what is kept would change it a little with each frame.
    transmittance_t kept = max(before.transmittance, 1e-6);
    transmittance_t deeper = log(kept / max(now.transmittance, 1e-6));
    Sight mean =
        Sight(mix(now.scattering, before.scattering, weight), mix(now.transmittance, before.transmittance, weight));
    transmittance_t alike = clamp(2.0 - 2.0 * abs(deeper), 0.0, 1.0);
    transmittance_t taken = 1.0 - mean.transmittance;
    mean.transmittance = mix(mean.transmittance, kept * exp((weight - 1.0) * deeper), alike);
    mean.scattering *= mix(transmittance_t(1.0), (1.0 - mean.transmittance) / max(taken, kClear), step(kClear, taken));
    return mean;
}

// What a texel's two targets hold.
struct KeptTexel {
    vec4 kept, more;
};

KeptTexel gather_history(ivec2 texel)
{
    Sight sight = sight_at(texel);
    vec2 media_depth = media_depth_at(texel);
    float scene_z = scene_z_at(texel);
    float frames = is_sound(sight) ? 1.0 : 0.0;
    Around now;
    Reprojected last = no_history(vec2(texel), scene_z);
    if (kHistory) {
        if (kMoved || kLightChanged)
            now = around(texel, sight, scene_z);
        if (kMoved && media_depth.x >= 0.0)
            media_depth = now.media_depth;
        last = history_of(texel, media_depth, scene_z);
    }
    Kept history = last.kept;
    if (history.frames > 0.0) {
        if (kMoved && last.whole)
            follow(now, last, history);
        if (kLightChanged)
            adapt(now, kept_around(last.position, last.old_scene_z), history);
        if (kMoved || kLightChanged)
            clip(now, kMoved || kMediaChanged, history.sight);
        float weight = min(history.frames / (history.frames + 1.0), u_history.weight);
        Sight mean = mean_of(sight, history.sight, weight);
        if (is_sound(mean)) {
            sight = mean;
            frames = 1.0 / (1.0 - weight);
        }
    }
    float depth = (scene_z - u_frame.media_range.x) / max(u_frame.media_range.y - u_frame.media_range.x, 1e-30);
    if (media_depth.x < 0.0)
        depth = -1.0;
    vec3 transmittance = vec3(sight.transmittance);
    return KeptTexel(vec4(sight.scattering, kMonochrome ? transmittance.r : frames),
                     kMonochrome ? vec4(frames, depth, 0.0, 0.0) : vec4(transmittance, depth));
}
