// The media of this scene: what they have at a point, and what they dim along a line. What each medium is,
// written/media.glsl says in functions of its own, which src/medium/media_source.cpp writes.
#ifndef extinction_t
#error extinction_t is not defined: this file needs the scene's media
#endif
#include "lib/grid.glsl"
#include "lib/profile.glsl"
#include "lib/ray_box.glsl"
#include "lib/slab.glsl"
#include "shared/bindings.h"
#include "scene/frame.glsl"
#include "shared/medium_params.h"

// Variant. extinction_t: a vec3 where the scene has coloured extinction, else one number.
const int kGridCount = 0;
const int kMediumCount = 0;
const bool kMixedG = false;         // media differ in g
const bool kIsotropic = false;      // no medium has g
const bool kEmission = false;       // some medium glows
const bool kShadowToLight = false;  // as in 2017 over the whole way to a light, whatever the medium fills of it
const bool kMinExtinction = false;  // 2017 kept clear of 0 / 0 so
const bool kIslands = false;        // some media have parts that lie far apart
const bool kPartSteps = false;      // or are small beside others: steps through each are its own
const bool kCountSamples = false;   // for the table that `render` prints

layout(std140, binding = MEDIA_BLOCK) uniform Media { MediaParams u_media; };

// Farther than any light that has a place: the range of a sun's shadow ray. [m]
const float kSunRange = 1e29;

int g_samples = 0;  // kCountSamples: evaluations of all media at a point

void count_sample()
{
    if (kCountSamples)
        ++g_samples;
}

// The block's numbers, read once before a loop: llvmpipe gathers each of them lane by lane, in some twenty
// instructions, wherever it is read, and takes none out of a loop by itself.
struct HeldMedia {
    GridParams grids[max(kGridCount, 1)];
    MediumParams media[max(kMediumCount, 1)];
};

HeldMedia held_media();  // written/media.glsl

// A point, eye-centred world [m], and where it is in each grid, in voxels.
struct MediaPoint {
    vec3 p;
    vec3 q[max(kGridCount, 1)];
    HeldMedia held;
};

MediaPoint media_point(vec3 p, HeldMedia held)
{
    MediaPoint at;
    at.p = p;
    for (int k = 0; k < kGridCount; ++k)
        at.q[k] = (held.grids[k].index_from_world * vec4(p, 1.0)).xyz;
    at.held = held;
    return at;
}

// A line through the media, its matrices multiplied once for all points on it: few compilers take them out
// of a loop by themselves.
struct MediaLine {
    Ray ray;
    vec3 q[max(kGridCount, 1)];
    vec3 dq[max(kGridCount, 1)];
    HeldMedia held;
};

MediaLine media_line(Ray ray)
{
    MediaLine line;
    line.ray = ray;
    line.held = held_media();
    for (int k = 0; k < kGridCount; ++k) {
        line.q[k] = (line.held.grids[k].index_from_world * vec4(ray.origin, 1.0)).xyz;
        line.dq[k] = (line.held.grids[k].index_from_world * vec4(ray.direction, 0.0)).xyz;
    }
    return line;
}

MediaPoint point_on(MediaLine line, float t)
{
    MediaPoint at;
    at.p = line.ray.origin + line.ray.direction * t;
    for (int k = 0; k < kGridCount; ++k)
        at.q[k] = line.q[k] + line.dq[k] * t;
    at.held = line.held;
    return at;
}

// max(0, (fbm - threshold) / (1 - threshold)), fbm the sum of octaves brought to 0..1.
float profile_noise(int m, vec3 p)
{
    MediumParams medium = u_media.media[m];
    if (!inside_bounds(medium, p))
        return 0.0;
    float sum = 0.0;
    float amplitude = 1.0;
    int octaves = medium.noise_octaves;
    int i = 0;
    do {  // llvmpipe runs a while loop's body once more with all lanes masked; do-while avoids it
        NoiseOctave octave = u_media.octaves[m * MAX_OCTAVES + i];
        vec3 q = p * octave.frequency + octave.fraction;
        vec3 whole = floor(q);
        sum += amplitude * noise_at(octave.cell_offset.xyz + ivec3(whole), uint(octave.cell_offset.w), q - whole);
        amplitude *= medium.noise_gain;
    } while (++i < octaves);
    float fbm = 0.5 + 0.5 * sum * medium.noise_scale;
    return max(0.0, (fbm - medium.noise_threshold) / (1.0 - medium.noise_threshold));
}

struct MediumSample {
    vec3 sigma_s;          // [1/m]
    extinction_t sigma_t;  // [1/m]
    vec3 emission;         // [W/m^2/sr per m]
    float g;
};

// Media add up; g is the mean weighted by sigma_s. phase: the sums of g times its weight and of the weight.
void add_medium(inout MediumSample sum, inout vec2 phase, MediumSample medium)
{
    sum.sigma_s += medium.sigma_s;
    sum.sigma_t += medium.sigma_t;
    sum.emission += medium.emission;
    float weight = medium.sigma_s.r + medium.sigma_s.g + medium.sigma_s.b;
    phase += vec2(weight * medium.g, weight);
}

// Where p + t d, t in [begin, end], is inside a medium. Empty: x >= y. A box's bounds are in metres already.
vec2 box_segment(MediumParams medium, vec3 p, vec3 d, float begin, float end)
{
    vec2 t = ray_box(p, d, medium.bounds_min, medium.bounds_max);
    return vec2(max(t.x, begin), min(t.y, end));
}

vec2 grid_segment(MediumParams medium, vec3 p, vec3 d, float begin, float end)
{
    p = (medium.bounds_from_world * vec4(p, 1.0)).xyz;
    d = (medium.bounds_from_world * vec4(d, 0.0)).xyz;
    return box_segment(medium, p, d, begin, end);
}

// From the first entry to the last exit.
void add_segment(inout vec2 all_media, vec2 t)
{
    if (t.x < t.y)
        all_media = vec2(min(all_media.x, t.x), max(all_media.y, t.y));
}

vec2 island_segment(Island island, vec3 p, vec3 d, float begin, float end)
{
    MediumParams medium = u_media.media[island.medium];
    medium.bounds_min = island.low;
    medium.bounds_max = island.high;
    return grid_segment(medium, p, d, begin, end);
}

// What lies in islands, or in media that are small beside others, a ray enters and leaves at ends of its steps, and
// takes shorter ones inside.
struct PartStretch {
    float end;   // where the ray next enters or leaves one
    float step;  // the longest step until then
};

// Of the ray p + t d from `z` on.
PartStretch part_stretch(vec3 p, vec3 d, float z)
{
    const float kSteps = 24.0;  // through a part
    PartStretch stretch = PartStretch(1e30, 1e30);
    for (int i = 0; i < u_media.island_count; ++i) {
        vec2 t = island_segment(u_media.islands[i], p, d, -1e30, 1e30);
        if (!(t.x < t.y) || t.y <= z)
            continue;
        if (t.x > z) {
            stretch.end = min(stretch.end, t.x);
        } else {
            stretch.end = min(stretch.end, t.y);
            stretch.step = min(stretch.step, (t.y - t.x) / kSteps);
        }
    }
    return stretch;
}

// Where a step from `z` on, which would go to `z_end`, ends in a stretch.
float part_step(PartStretch stretch, float z, float z_end)
{
    const float kLeast = 1.0 + 2e-6;  // that a float shows
    return min(min(z_end, stretch.end), max(z + stretch.step, z * kLeast));
}

// Of a way of `range` metres to a light, what a medium dims, where `inside` is what it fills of it.
vec2 shadow_segment(vec2 inside, float range)
{
    return kShadowToLight && range < kSunRange ? vec2(0.0, range) : inside;
}

// The integral of exp((z0 - z) / scale_height) along p + t wi, from its lower end: from the upper one, exp of many
// heights down would overflow.
float exp_height_depth(MediumParams medium, vec3 p, vec3 wi, vec2 t)
{
    float ds = t.y - t.x;
    float low = p.z + wi.z * (wi.z < 0.0 ? t.y : t.x);
    return ds * exp_height_at(medium, low) * slab_weight(abs(wi.z) * ds * medium.inverse_scale_height);
}

#include "written/media.glsl"

MediumSample sample_media(MediaPoint at)
{
    count_sample();
    MediumSample s = MediumSample(vec3(0.0), extinction_t(0.0), vec3(0.0), at.held.media[0].g);
    vec2 phase = vec2(0.0);
    add_media(s, phase, at);
    if (kMixedG)
        s.g = phase.y > 0.0 ? phase.x / phase.y : 0.0;
    if (kMinExtinction)
        s.sigma_t = max(s.sigma_t, u_frame.min_extinction);
    return s;
}

MediumSample sample_media(vec3 p) { return sample_media(media_point(p, held_media())); }

// Optical depth of all media from p along wi over a length of `range` metres: what has no closed form in `steps`
// midpoint steps within each medium's bounds.
extinction_t optical_depth(vec3 p, vec3 wi, float range, int steps)
{
    return closed_depth(p, wi, range) + marched_depth(p, wi, range, steps);
}
