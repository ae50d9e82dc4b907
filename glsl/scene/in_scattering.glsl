// Light that media scatter towards the eye at points of a line: every light and the world, once.
//
// Variant, besides those of scene/light_volumes.glsl:
//   VOLUME_SHADOWS   media dim the light on its way to the point
//   WORLD_LIGHT      the world's light scatters too: its mean radiance, undimmed, isotropically, unless
//                    there is a WORLD_VOLUME
//   ISOTROPIC        no medium has g
//   ALL_MARCHED      media that scatter are marched ones: a point that does is in the depth volume
//   EXACT_FALLOFF    a step takes the mean of 1/d^2 over its length, not that at its sample; and ray_march.frag
//                    looks up other light where a step has it count
//   LIGHT_DEPTH      a function of a light's number, the point and its LightSample: the media's optical
//                    depth between, if not that of the media themselves
#include "lib/phase.glsl"
#include "lib/falloff.glsl"
#include "scene/frame.glsl"
#include "scene/light_volumes.glsl"

#if SUN_COUNT > 0
#define SUN_SLOTS SUN_COUNT
#else
#define SUN_SLOTS 1
#endif

#if LIGHT_COUNT > SUN_COUNT
#define PLACED_SLOTS (LIGHT_COUNT - SUN_COUNT)
#else
#define PLACED_SLOTS 1
#endif

// A line, and all that its points are looked up by: what is the same along it, and what grows evenly with t,
// as begin + t * slope. Worked out once a line: few compilers take it out of a loop by themselves.
struct LightLine {
    Ray ray;
    vec3 wo;  // unit length, to the eye
    vec3 sun[SUN_SLOTS];  // what it scatters if nothing hides or dims it; MIXED_G: its irradiance
    vec3 shadow[SUN_SLOTS], dshadow[SUN_SLOTS];  // its inner shadow view, which holds all media: uv, depth
    vec3 depth, ddepth;  // texture coordinates in the first layer of the depth volume
    vec3 world, dworld;  // and of the world's
    vec2 placed[PLACED_SLOTS];  // EXACT_FALLOFF: t nearest to a light that has a place, and how far it is [m]
};

float phase_at(float cos_theta, float g)
{
#ifdef ISOTROPIC
    return phase_isotropic();
#else
    float g_clamp = u_frame.g_clamp;
    return phase_henyey_greenstein(cos_theta, clamp(g, -g_clamp, g_clamp));
#endif
}

float phase_of(LightSample light, vec3 wo, float g) { return phase_at(dot(-light.wi, wo), g); }

// wo: unit length, to the eye. spread: how wide the square is that the line stands for, at its origin and more
// of it per unit of t [m].
LightLine light_line(Ray ray, vec3 wo, vec2 spread)
{
    LightLine line;
    line.ray = ray;
    line.wo = wo;
    for (int i = 0; i < SUN_COUNT; ++i) {
        line.sun[i] = u_lights.lights[i].intensity;
#ifndef MIXED_G
        line.sun[i] *= phase_at(dot(-u_lights.lights[i].position, wo), u_media.media[0].g);
#endif
#ifdef SURFACE_SHADOWS
        ShadowView view = u_lights.views[int(u_lights.lights[i].first_view)];
        line.shadow[i] = vec3((view.clip_from_world * vec4(ray.origin, 1.0)).xy * 0.5 + 0.5,
                              dot(ray.origin - view.depth.origin, view.depth.travel) * view.depth.inverse_range);
        line.dshadow[i] = vec3((view.clip_from_world * vec4(ray.direction, 0.0)).xy * 0.5,
                               dot(ray.direction, view.depth.travel) * view.depth.inverse_range);
#endif
    }
#ifdef DEPTH_VOLUME
    line.depth = first_layer_at(u_volumes.depth, ray.origin);
    line.ddepth = first_layer_way(u_volumes.depth, ray.direction);
#endif
#ifdef WORLD_VOLUME
    line.world = first_layer_at(u_volumes.world, ray.origin);
    line.dworld = first_layer_way(u_volumes.world, ray.direction);
#endif
#ifdef EXACT_FALLOFF
    for (int i = SUN_COUNT; i < LIGHT_COUNT; ++i) {
        vec3 to_light = u_lights.lights[i].position - ray.origin;
        float t = dot(to_light, ray.direction) / dot(ray.direction, ray.direction);
        vec3 from_line = to_light - ray.direction * t;
        float disc = inversesqrt(kPi) * max(spread.x + spread.y * t, 0.0);  // as large as the square
        line.placed[i - SUN_COUNT] = vec2(t, max(distance_of_disc(dot(from_line, from_line), disc), kLeastRange));
    }
#endif
    return line;
}

#ifdef VOLUME_SHADOWS
vec3 volume_shadow(int i, LightLine line, float t, LightSample light)
{
    vec3 p = line.ray.origin + line.ray.direction * t;
#ifdef LIGHT_DEPTH
    return vec3(exp(-LIGHT_DEPTH(i, p, light)));
#elif defined(DEPTH_VOLUME) && defined(ALL_MARCHED)
    return vec3(exp(-closed_depth(p, light.wi, light.range) - stored_depth(i, line.depth + line.ddepth * t)));
#else
    return vec3(exp(-depth_to_light(i, p, light)));
#endif
}
#else
#define volume_shadow(i, line, t, light) 1.0
#endif

#ifdef EXACT_FALLOFF
// The mean over a step of the phase of a light that has a place, weighted as its light is: evenly in the angle.
// Past a light that is near it swings from one end of the phase to the other within a step. Gauss and
// Legendre's three points.
float phase_over(Falloff falloff, float g)
{
#ifdef ISOTROPIC
    return phase_isotropic();
#else
    float middle = falloff.begin + 0.5 * falloff.angle;
    float reach = 0.3872983346 * falloff.angle;
    return (4.0 * phase_at(-sin(middle), g) + 2.5 * (phase_at(-sin(middle - reach), g) +
                                                    phase_at(-sin(middle + reach), g))) / 9.0;
#endif
}
#endif

// A light that has a place, at t or, EXACT_FALLOFF, over the step whose ends are `step` and that is sampled at
// `share` of it; t becomes where the light is looked up. Its irradiance, times the phase, and times what sigma_t
// leaves of a step's light between where this light has its middle and the step's own.
LightSample placed_light(int i, LightLine line, vec2 step, float share, float g, extinction_t sigma_t, inout float t)
{
#ifdef EXACT_FALLOFF
    vec2 nearest = line.placed[i - SUN_COUNT];
    float metres = length(line.ray.direction);
    vec2 s = (step - nearest.x) * metres;
    Falloff over = falloff_over(s, nearest.y, share);
    t = nearest.x + over.place / metres;
    LightSample light = light_sample(i, line.ray.origin + line.ray.direction * t);
    light.irradiance *= over.mean * light.range * light.range * phase_over(over, g) * exp(-sigma_t * over.ahead);
#else
    LightSample light = light_sample(i, line.ray.origin + line.ray.direction * t);
    light.irradiance *= phase_of(light, line.wo, g);
#endif
    return light;
}

// Radiance scattered towards the eye, per metre of line and unit of sigma_s, at t of a step whose ends are
// `step`; share: of the step's length that lies before t; sigma_t: of the medium there.
vec3 in_scattering_on(LightLine line, float t, vec2 step, float share, float g, extinction_t sigma_t)
{
    vec3 in_scattering = vec3(0.0);
#if defined(WORLD_VOLUME)
    in_scattering += world_in_scattering(line.world + line.dworld * t, g);
#elif defined(WORLD_LIGHT)
    in_scattering += u_lights.world_radiance.rgb;  // 4 pi sr of it, times the isotropic 1 / (4 pi)
#endif
    for (int i = 0; i < SUN_COUNT; ++i) {
        LightSample light = light_sample(i, vec3(0.0));
        vec3 arriving = line.sun[i];
#ifdef MIXED_G
        arriving *= phase_of(light, line.wo, g);
#endif
#ifdef SURFACE_SHADOWS
        vec3 shadow = line.shadow[i] + line.dshadow[i] * t;
        arriving *= visibility_in(int(u_lights.lights[i].first_view), shadow.xy, shadow.z);
#endif
        in_scattering += arriving * volume_shadow(i, line, t, light);
    }
    for (int i = SUN_COUNT; i < LIGHT_COUNT; ++i) {
        float t_light = t;
        LightSample light = placed_light(i, line, step, share, g, sigma_t, t_light);
        vec3 arriving = light.irradiance;
#ifdef SURFACE_SHADOWS
        arriving *= placed_visibility(i, line.ray.origin + line.ray.direction * t_light, light);
#endif
        in_scattering += arriving * volume_shadow(i, line, t_light, light);
    }
    return in_scattering;
}

// The same at a point. wo: unit length, to the eye.
vec3 in_scattering_at(vec3 p, vec3 wo, float g)
{
    return in_scattering_on(light_line(Ray(p, vec3(0.0)), wo, vec2(0.0)), 0.0, vec2(0.0), 0.0, g,
                            extinction_t(0.0));
}
