// The ray march: what the media do to each pixel of the volume layer, between the eye and the scene's
// depth. Eevee's design of July 2017.
//   in   the layer's depth (view_z [m]), the scene's media and lights, blue noise
//   out  scattering     radiance scattered and emitted towards the eye [W/m^2/sr]
//        transmittance  per channel, 0..1
//        or, MONOCHROME, one target: scattering in rgb, mean transmittance in alpha
//        media depth    MEDIA_DEPTH: where what the ray sees of the media lies, mean and standard deviation, as
//                       fractions of their range of view depth; -1: there are none on its way. In the alphas,
//                       or, MONOCHROME, in the second target
//
// Variant, besides those of scene/in_scattering.glsl:
//   BLUE_NOISE       sample each step at an offset of its own per pixel, else at its middle
//   CAMERA_RANGE     march from near to far and past the scene's depth as 2017 did, sampling the end
//                    of each step; else only where media are, each step cut exactly at both ends
//   STEP_TILES       steps lie where the tile's bricks hold something, stride of them in one; else all along
//   MEDIA_DEPTH      work out a depth that stands for the ray's media, for march_history.frag
//   COUNT_SAMPLES    write the number of media evaluations instead
#include "lib/step_lattice.glsl"
#include "scene/in_scattering.glsl"

layout(binding = LAYER_DEPTH_UNIT) uniform sampler2D u_layer_depth_tx;
#ifdef BLUE_NOISE
layout(binding = BLUE_NOISE_UNIT) uniform sampler2D u_blue_noise_tx;
#endif

#ifdef STEP_TILES
flat in vec3 tile;  // pass/tiles.vert
#endif
layout(location = 0) out vec4 out_scattering;
#if defined(MONOCHROME) && defined(MEDIA_DEPTH)
layout(location = 1) out vec2 out_media_depth;
#else
layout(location = 1) out vec4 out_transmittance;
#endif

#ifdef MEDIA_DEPTH
// Sums of weights, x, of weights times view depth from the nearest, y, and times its square, z. What is seen
// of a medium is the light that comes from it, or, where none does, that it hides what is behind.
struct MediaDepth {
    vec3 shining, hiding;
};

vec2 media_depth_of(MediaDepth sums, float nearest, float farthest)
{
    if (!(nearest < farthest))
        return vec2(-1.0, 0.0);
    vec3 sum = sums.shining.x > 0.0 ? sums.shining : sums.hiding;
    float most = farthest - nearest;
    float mean = sum.y / sum.x;
    float spread = sqrt(max(sum.z / sum.x - mean * mean, 0.0));
    if (!(mean >= 0.0 && mean <= most && spread <= most)) {  // nothing was seen, or too much
        mean = 0.5 * most;
        spread = 0.0;
    }
    return vec2(nearest - u_frame.media_range.x + mean, spread) /
           max(u_frame.media_range.y - u_frame.media_range.x, 1e-30);
}
#endif

float most(float v) { return v; }
float most(vec3 v) { return max(v.r, max(v.g, v.b)); }

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    vec2 pixel = (gl_FragCoord.xy + u_frame.layer_offset.xy) * float(LAYER_SCALE);
    vec2 ndc = pixel * u_frame.full_size.zw * 2.0 - 1.0;
    Ray ray = camera_ray(ndc);
    float length_per_z = length(ray.direction);
    vec3 wo = -ray.direction / length_per_z;

    int steps = int(u_frame.march.x);
    float lambda = u_frame.march.y;
    vec2 range = u_frame.step_range.xy;
    float octaves = u_frame.step_range.z;
    float scene_z = texelFetch(u_layer_depth_tx, texel, 0).r;
#ifdef BLUE_NOISE
    float noise = texelFetch(u_blue_noise_tx, texel & (BLUE_NOISE_SIZE - 1), 0).r;
    float offset = fract(noise + u_frame.march.w);
#else
    float offset = 0.5;
#endif

#ifdef CAMERA_RANGE
    vec2 inside = vec2(range.x, scene_z);
    int first = 0;
#else
    vec2 inside = media_segment(ray.origin, ray.direction, u_frame.media_range.x,
                                min(scene_z, u_frame.media_range.y));
    float end = inside.y;
    int stride = 1;
    int first = steps;
#ifdef STEP_TILES
    // Steps stay where they are whether some of them are left out or not.
    stride = int(tile.z);
    end = min(end, tile.y);
    if (max(inside.x, tile.x) < end)
        first = step_at(max(inside.x, tile.x), steps, range, octaves, lambda) & -stride;
    inside.x = max(inside.x, step_split(float(first) / float(steps), range, octaves, lambda));
#else
    if (inside.x < inside.y)
        first = step_at(inside.x, steps, range, octaves, lambda);
#endif
#endif
    // A pixel's ray is its middle's; a larger texel's stands for the pixels around as well.
    float texel_ndc = 2.0 * sqrt(float(LAYER_SCALE * LAYER_SCALE - 1)) * u_frame.full_size.z;
    LightLine light = light_line(ray, wo, texel_ndc * vec2(length(u_frame.ray_origin_dx.xyz),
                                                           length(u_frame.ray_direction_dx.xyz)));
    MediaLine line = media_line(ray);
    float enough = u_frame.step_range.w;

    vec3 scattering = vec3(0.0);
    extinction_t transmittance = extinction_t(1.0);
    float z = inside.x;
#ifdef MEDIA_DEPTH
    MediaDepth seen = MediaDepth(vec3(0.0), vec3(0.0));
#endif
#ifdef CAMERA_RANGE
    for (int i = first; i < steps && z < inside.y; ++i) {
        float z_next = step_split((float(i) + 0.5 + offset) / float(steps), range, octaves, lambda);
        float share = 1.0;
        float z_sample = z_next;
#else
    for (int i = first; i < steps && z < end && most(transmittance) > enough; i += stride) {
        float z_next = min(step_split(float(i + stride) / float(steps), range, octaves, lambda), inside.y);
        if (i + stride >= steps)
            z_next = inside.y;  // rounding must not leave a rest
        // Where steps are long, since the medium is smooth, every other one is sampled as far from its end as
        // the one before was from its begin: what grows evenly along the ray then has no noise. Detail is
        // better met at even distances.
        float share = stride == 1 || (i & stride) == 0 ? offset : 1.0 - offset;
        float z_sample = mix(z, z_next, share);
#endif
        float ds = (z_next - z) * length_per_z;
        MediumSample medium = sample_media(point_on(line, z_sample));
        vec3 source = medium.emission;
        if (medium.sigma_s != vec3(0.0))
            source += medium.sigma_s * in_scattering_on(light, z_sample, vec2(z, z_next), share, medium.g);
        extinction_t tau = medium.sigma_t * ds;
        vec3 added = transmittance * source * (ds * slab_weight(tau));
        scattering += added;
#ifdef MEDIA_DEPTH
        float from_nearest = 0.5 * (z + z_next) - inside.x;
        vec3 powers = vec3(1.0, from_nearest, from_nearest * from_nearest);
        seen.shining += most(added) * powers;
        seen.hiding += most(transmittance * (1.0 - exp(-tau))) * powers;
#endif
        transmittance *= exp(-tau);
        z = z_next;
    }

#ifdef COUNT_SAMPLES
    out_scattering = vec4(float(g_samples));
#else
#ifdef MEDIA_DEPTH
#ifdef CAMERA_RANGE
    float farthest = inside.y;
#else
    float farthest = end;
#endif
    vec2 media_depth = media_depth_of(seen, inside.x, farthest);
#endif
    scattering = min(scattering, vec3(u_frame.resolve.y));  // an infinity would spoil its neighbours
#ifdef MONOCHROME
    out_scattering = vec4(scattering, dot(vec3(transmittance), vec3(1.0 / 3.0)));
#ifdef MEDIA_DEPTH
    out_media_depth = media_depth;
#endif
#else
#ifdef MEDIA_DEPTH
    out_scattering = vec4(scattering, media_depth.x);
    out_transmittance = vec4(vec3(transmittance), media_depth.y);
#else
    out_scattering = vec4(scattering, 1.0);
    out_transmittance = vec4(vec3(transmittance), 1.0);
#endif
#endif
#endif
}
