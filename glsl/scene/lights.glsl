// The lights of this scene at a point: how much arrives, from where, and what surfaces let through. Each type
// has its functions, which take the number of a light's first point; src/light/light_source.cpp writes what calls
// them for the lights that there are.
#include "lib/shadow.glsl"
#include "shared/bindings.h"
#include "shared/light_params.h"

// Variant
const int kSunCount = 0;             // suns are the first of lights[],
const int kPointCount = 0;           // then come points,
const int kSpotCount = 0;            // then spots
const int kLightPoints = 0;          // lights[] that there are
const bool kFlames = false;          // some points stand for flames
const bool kSurfaceShadows = false;  // the scene has surfaces that can hide a light

const int kPlacedCount = kPointCount + kSpotCount;

#ifdef LIGHT_FILTERS
#include "scene/light_filters.glsl"
#else
const bool kLightFilters = false;  // transparents colour light on its way
vec3 filter_on_surface(int i, vec3 p) { return vec3(1.0); }
vec3 filter_in_medium(int i, vec3 p) { return vec3(1.0); }
#endif

layout(std140, binding = LIGHTS_BLOCK) uniform Lights { LightsParams u_lights; };
layout(binding = SHADOW_MAP_UNIT) uniform sampler2DArrayShadow u_shadow_map_tx;

// At a light itself 1/d^2 has no value; a hundredth of a millimetre stands for it, far below a step. [m]
const float kLeastRange = 1e-5;

struct LightSample {
    vec3 wi;          // to the light, unit length
    float range;      // metres to it
    vec3 irradiance;  // that it gives a plane facing it, if nothing is in between [W/m^2]
    bool is_sun;      // in a loop over lights a number does not tell a compiler so
};

LightSample sun_sample(int i, vec3 p)
{
    return LightSample(u_lights.lights[i].position, 1e30, u_lights.lights[i].intensity, true);
}

//   radius  [m] within which it does not grow any more: of a flame, else 0
LightSample sample_of(vec3 position, vec3 intensity, float radius, vec3 p)
{
    vec3 to_light = position - p;
    float range2 = max(dot(to_light, to_light), kLeastRange * kLeastRange);
    float range = sqrt(range2);
    float least2 = kFlames ? max(range2, radius * radius) : range2;
    return LightSample(to_light / range, range, intensity / least2, false);
}

// Of the disc that point i looks as large as [m].
float flame_radius(int i) { return kFlames && i < kSunCount + kPointCount ? u_lights.lights[i].own[0].x : 0.0; }

LightSample point_sample(int i, vec3 p)
{
    return sample_of(u_lights.lights[i].position, u_lights.lights[i].intensity, flame_radius(i), p);
}

LightSample spot_sample(int i, vec3 p)
{
    vec4 own[4] = u_lights.lights[i].own;
    SpotParams spot = SpotParams(own[0].xyz, own[0].w, own[1].x);
    LightSample s = point_sample(i, p);
    s.irradiance *= smoothstep(0.0, 1.0, (dot(-s.wi, spot.axis) - spot.cos_half_cone) * spot.inverse_edge_width);
    return s;
}

// 1 where a view sees p, 0 where a surface hides it. n: the normal of the surface that p lies on.
float visibility_on_surface(int view, vec3 p, vec3 n)
{
    if (!kSurfaceShadows)
        return 1.0;
    ShadowView shadow = u_lights.views[view];
    ShadowSlack slack = shadow_slack(shadow.depth, p, n);
    p += n * slack.lift;
    float depth = shadow_depth(shadow.depth, p) - slack.nearer * shadow.depth.inverse_range;
    vec4 clip = shadow.clip_from_world * vec4(p, 1.0);
    vec2 uv = clip.xy / clip.w * 0.5 + 0.5;
    return texture(u_shadow_map_tx, vec4(uv, float(view), clamp(depth, 0.0, 1.0)));
}

float sun_on_surface(int i, vec3 p, vec3 n)
{
    int view = int(u_lights.lights[i].first_view);
    // The inner view has the detail, the outer one holds everything.
    vec4 inner = u_lights.views[view].clip_from_world * vec4(p, 1.0);
    if (any(greaterThan(abs(inner.xy), vec2(1.0))))
        ++view;
    return visibility_on_surface(view, p, n);
}

float point_on_surface(int i, vec3 p, vec3 n)
{
    int view = int(u_lights.lights[i].first_view) + cube_face(p - u_lights.lights[i].position);
    return visibility_on_surface(view, p, n);
}

float spot_on_surface(int i, vec3 p, vec3 n) { return visibility_on_surface(int(u_lights.lights[i].first_view), p, n); }

// The same in a medium, of what lies at uv, 0..1, and depth in a view.
float visibility_in(int view, vec2 uv, float depth)
{
    if (!kSurfaceShadows)
        return 1.0;
    return texture(u_shadow_map_tx, vec4(uv, float(view), clamp(depth, 0.0, 1.0)));
}

// Of a light that has a place, light.range metres along light.wi from p.
float point_visibility(int i, vec3 p, LightSample light)
{
    int view = int(u_lights.lights[i].first_view);
    float depth = light.range * u_lights.views[view].depth.inverse_range;
    int face;
    vec2 on_face = on_cube_face(-light.wi, face);
    return visibility_in(view + face, on_face * u_lights.lights[i].cube_view_scale + 0.5, depth);
}

float spot_visibility(int i, vec3 p, LightSample light)
{
    int view = int(u_lights.lights[i].first_view);
    float depth = light.range * u_lights.views[view].depth.inverse_range;
    vec4 clip = u_lights.views[view].clip_from_world * vec4(p, 1.0);
    return visibility_in(view, clip.xy / clip.w * 0.5 + 0.5, depth);
}
