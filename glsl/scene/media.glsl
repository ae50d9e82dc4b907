// The media of this scene: their bindings, and the sums over them.
//
// The variant lists the scene's media in one macro, so every loop over them is unrolled, each medium
// runs the code of its own kind alone, and textures are indexed by constants:
//   #define FOR_EACH_MEDIUM(X)  X(m, value, depth, k, tint, c) ...
//     m      its number in media[]
//     value  coefficient at a point: dense_scalar, bricks_scalar, dense_rgb, bricks_rgb (k: its grid),
//            homogeneous, exp_height, noise (k: m)
//     depth  coefficient summed along a ray: marched_depth, homogeneous_depth, exp_height_depth, or
//            no_depth of a medium that only glows
//     tint   of sigma_s: white, or dense_rgb, bricks_rgb (c: its grid)
//   #define FOR_EACH_EMISSION(X)  X(m, value, k) ...
// and says whether extinction has a colour (COLORED_EXTINCTION), whether media differ in g (MIXED_G), and as
// bits which media have the bounds of a grid (GRID_MEDIA); others have those of a box.
#ifndef FOR_EACH_MEDIUM
#error FOR_EACH_MEDIUM is not defined: this file needs the scene's media
#endif
#include "lib/grid.glsl"
#include "lib/profile.glsl"
#include "lib/ray_box.glsl"
#include "lib/slab.glsl"
#include "shared/bindings.h"
#include "scene/frame.glsl"
#include "shared/medium_params.h"

layout(std140, binding = MEDIA_BLOCK) uniform Media { MediaParams u_media; };
#if GRID_COUNT > 0
layout(binding = GRID_UNIT) uniform sampler3D u_grid_tx[GRID_COUNT];
#endif
#if BRICK_COUNT > 0
layout(binding = GRID_UNIT + GRID_COUNT) uniform usampler3D u_page_tx[GRID_COUNT];
#endif

// Farther than any light that has a place: the range of a sun's shadow ray. [m]
const float kSunRange = 1e29;

// Extinction and what follows from it: a colour where the scene has coloured extinction, else one number.
#ifdef COLORED_EXTINCTION
#define extinction_t vec3
#define EXTINCTION rgb
#else
#define extinction_t float
#define EXTINCTION a
#endif

// What a medium's density gives: one number, or a colour if a density grid is a vec3.
#ifdef COLORED_DENSITY
#define coefficient_t vec3
#else
#define coefficient_t float
#endif

#ifdef COUNT_SAMPLES
int g_samples = 0;  // evaluations of all media at a point, for the table that `render` prints
#define COUNT_SAMPLE ++g_samples;
#else
#define COUNT_SAMPLE
#endif

#if GRID_COUNT > 0
#define GRID_SLOTS GRID_COUNT
#else
#define GRID_SLOTS 1
#endif

// A point, eye-centred world [m], and where it is in each grid, in voxels.
struct MediaPoint {
    vec3 p;
    vec3 q[GRID_SLOTS];
};

MediaPoint media_point(vec3 p)
{
    MediaPoint at;
    at.p = p;
    for (int k = 0; k < GRID_COUNT; ++k)
        at.q[k] = (u_media.grids[k].index_from_world * vec4(p, 1.0)).xyz;
    return at;
}

// A line through the media, its matrices multiplied once for all points on it: few compilers take them out
// of a loop by themselves.
struct MediaLine {
    Ray ray;
    vec3 q[GRID_SLOTS];
    vec3 dq[GRID_SLOTS];
};

MediaLine media_line(Ray ray)
{
    MediaLine line;
    line.ray = ray;
    for (int k = 0; k < GRID_COUNT; ++k) {
        line.q[k] = (u_media.grids[k].index_from_world * vec4(ray.origin, 1.0)).xyz;
        line.dq[k] = (u_media.grids[k].index_from_world * vec4(ray.direction, 0.0)).xyz;
    }
    return line;
}

MediaPoint point_on(MediaLine line, float t)
{
    MediaPoint at;
    at.p = line.ray.origin + line.ray.direction * t;
    for (int k = 0; k < GRID_COUNT; ++k)
        at.q[k] = line.q[k] + line.dq[k] * t;
    return at;
}

#define dense_scalar(k, at) sample_dense(u_grid_tx[k], u_media.grids[k], at.q[k]).r
#define dense_rgb(k, at) sample_dense(u_grid_tx[k], u_media.grids[k], at.q[k]).rgb
#define bricks_scalar(k, at) sample_bricks(u_grid_tx[k], u_page_tx[k], u_media.grids[k], at.q[k]).r
#define bricks_rgb(k, at) sample_bricks(u_grid_tx[k], u_page_tx[k], u_media.grids[k], at.q[k]).rgb
#define homogeneous(m, at) profile_homogeneous(u_media.media[m], at.p)
#define exp_height(m, at) profile_exp_height(u_media.media[m], at.p)
#define noise(m, at) profile_noise(m, at.p)
#define white(c, at) 1.0

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
    do {  // a loop that asks first runs once more where the lanes of a processor are one
        NoiseOctave octave = u_media.octaves[m * MAX_OCTAVES + i];
        vec3 q = p * octave.frequency + octave.fraction;
        vec3 whole = floor(q);
        sum += amplitude * noise_at(octave.cell_offset.xyz + ivec3(whole),
                                    uint(octave.cell_offset.w), q - whole);
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

MediumSample sample_media(MediaPoint at)
{
    COUNT_SAMPLE
    MediumSample s = MediumSample(vec3(0.0), extinction_t(0.0), vec3(0.0), u_media.media[0].g);
#ifdef MIXED_G
    float g_weight = 0.0;
    float g_sum = 0.0;
#define ADD_G(m, added) \
    { float w = added.r + added.g + added.b; g_weight += w; g_sum += w * u_media.media[m].g; }
#else
#define ADD_G(m, added)
#endif
#define ADD_MEDIUM(m, value, depth, k, tint, c)                               \
    {                                                                         \
        coefficient_t coefficient = coefficient_t(value(k, at));              \
        vec3 added = u_media.media[m].sigma_s * coefficient * (tint(c, at)); \
        s.sigma_s += added;                                                   \
        s.sigma_t += u_media.media[m].sigma_t.EXTINCTION * coefficient;       \
        ADD_G(m, added)                                                       \
    }
    FOR_EACH_MEDIUM(ADD_MEDIUM)
#ifdef MIXED_G
    s.g = g_weight > 0.0 ? g_sum / g_weight : 0.0;
#endif
#ifdef FOR_EACH_EMISSION
#define ADD_EMISSION(m, value, k) s.emission += u_media.media[m].emission * (value(k, at));
    FOR_EACH_EMISSION(ADD_EMISSION)
#endif
#ifdef LEAST_EXTINCTION
    s.sigma_t = max(s.sigma_t, u_frame.min_extinction);  // 2017 kept clear of 0 / 0 so
#endif
    return s;
}

MediumSample sample_media(vec3 p) { return sample_media(media_point(p)); }

// Where p + t d, t in [begin, end], is inside medium m. Empty: x >= y.
vec2 medium_segment(int m, vec3 p, vec3 d, float begin, float end)
{
    MediumParams medium = u_media.media[m];
    if (((GRID_MEDIA >> m) & 1u) != 0u) {  // known as the shader is built; a box's bounds are in metres already
        p = (medium.bounds_from_world * vec4(p, 1.0)).xyz;
        d = (medium.bounds_from_world * vec4(d, 0.0)).xyz;
    }
    vec2 t = ray_box(p, d, medium.bounds_min, medium.bounds_max);
    return vec2(max(t.x, begin), min(t.y, end));
}

// Where p + t d, t in [begin, end], can meet a medium at all: from the first entry to the last exit.
vec2 media_segment(vec3 p, vec3 d, float begin, float end)
{
    vec2 all_media = vec2(end, begin);
#define ADD_SEGMENT(m, value, depth, k, tint, c)                       \
    {                                                                  \
        vec2 t = medium_segment(m, p, d, begin, end);                  \
        if (t.x < t.y)                                                 \
            all_media = vec2(min(all_media.x, t.x), max(all_media.y, t.y)); \
    }
    FOR_EACH_MEDIUM(ADD_SEGMENT)
    return all_media;
}

// Optical depth from p along wi over a length of `range` metres.
#ifdef SHADOW_TO_LIGHT  // 2017: over the whole way to a light, whatever the medium fills of it
#define SHADOW_SEGMENT(m) (range < kSunRange ? vec2(0.0, range) : medium_segment(m, p, wi, 0.0, range))
#else
#define SHADOW_SEGMENT(m) medium_segment(m, p, wi, 0.0, range)
#endif
#define ADD_DEPTH(m, value, depth, k, tint, c) \
    {                                          \
        vec2 t = SHADOW_SEGMENT(m);            \
        if (t.x < t.y)                         \
            depth(m, value, k)                 \
    }
#define no_depth(m, value, k) ;

// Of the media that have a closed form.
extinction_t closed_depth(vec3 p, vec3 wi, float range)
{
    extinction_t tau = extinction_t(0.0);
#define marched_depth(m, value, k) ;
#define homogeneous_depth(m, value, k) tau += u_media.media[m].sigma_t.EXTINCTION * (t.y - t.x);
// The integral of exp((z0 - z) / scale_height) along the segment, from its lower end: from the upper
// one, exp of many heights down would overflow.
#define exp_height_depth(m, value, k)                                                      \
    {                                                                                      \
        float ds = t.y - t.x;                                                              \
        float low = p.z + wi.z * (wi.z < 0.0 ? t.y : t.x);                                 \
        tau += u_media.media[m].sigma_t.EXTINCTION * ds * exp_height_at(u_media.media[m], low) * \
               slab_weight(abs(wi.z) * ds * u_media.media[m].inverse_scale_height);                                    \
    }
    FOR_EACH_MEDIUM(ADD_DEPTH)
    return tau;
}
#undef marched_depth
#undef homogeneous_depth
#undef exp_height_depth
#define homogeneous_depth(m, value, k) ;
#define exp_height_depth(m, value, k) ;

// Of all: the rest in `steps` midpoint steps within each medium's bounds.
extinction_t optical_depth(vec3 p, vec3 wi, float range, int steps)
{
    extinction_t tau = closed_depth(p, wi, range);
#define marched_depth(m, value, k)                                                 \
    {                                                                              \
        coefficient_t sum = coefficient_t(0.0);                                    \
        float ds = (t.y - t.x) / float(steps);                                     \
        for (int j = 0; j < steps; ++j) {                                          \
            COUNT_SAMPLE                                                           \
            MediaPoint at = media_point(p + wi * (t.x + (float(j) + 0.5) * ds));       \
            sum += coefficient_t(value(k, at));                                    \
        }                                                                          \
        tau += u_media.media[m].sigma_t.EXTINCTION * sum * ds;                     \
    }
    FOR_EACH_MEDIUM(ADD_DEPTH)
    return tau;
}
#undef marched_depth

// Extinction at p of the media whose depth is marched [1/m].
extinction_t marched_extinction(vec3 p)
{
    extinction_t sigma_t = extinction_t(0.0);
    MediaPoint at = media_point(p);
#define marched_depth(m, value, k) \
    sigma_t += u_media.media[m].sigma_t.EXTINCTION * coefficient_t(value(k, at));
#define ADD_EXTINCTION(m, value, depth, k, tint, c) depth(m, value, k)
    FOR_EACH_MEDIUM(ADD_EXTINCTION)
    return sigma_t;
}
