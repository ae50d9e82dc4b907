// The lights of this scene at a point: how much arrives, from where, and what surfaces let through.
//   SUN_COUNT, POINT_COUNT, SPOT_COUNT  how many of each there are, in this order in lights[]
//   SURFACE_SHADOWS                     defined where the scene has surfaces that can hide a light
#ifndef SUN_COUNT
#error SUN_COUNT, POINT_COUNT and SPOT_COUNT are not defined: this file needs the scene's lights
#endif
#include "lib/shadow.glsl"
#include "shared/bindings.h"
#include "shared/light_params.h"

#define LIGHT_COUNT (SUN_COUNT + POINT_COUNT + SPOT_COUNT)

layout(std140, binding = LIGHTS_BLOCK) uniform Lights { LightsParams u_lights; };
#ifdef SURFACE_SHADOWS
layout(binding = SHADOW_MAP_UNIT) uniform sampler2DArrayShadow u_shadow_map_tx;
#endif

// At a light itself 1/d^2 has no value; a hundredth of a millimetre stands for it, far below a step. [m]
const float kLeastRange = 1e-5;

struct LightSample {
    vec3 wi;          // to the light, unit length
    float range;      // metres to it
    vec3 irradiance;  // that it gives a plane facing it, if nothing is in between [W/m^2]
};

LightSample light_sample(int i, vec3 p)
{
    LightParams light = u_lights.lights[i];
    if (i < SUN_COUNT)
        return LightSample(light.position, 1e30, light.intensity);
    vec3 to_light = light.position - p;
    float range2 = max(dot(to_light, to_light), kLeastRange * kLeastRange);
    float range = sqrt(range2);
    LightSample s = LightSample(to_light / range, range, light.intensity / range2);
    if (i >= SUN_COUNT + POINT_COUNT)
        s.irradiance *= smoothstep(0.0, 1.0, (dot(-s.wi, light.axis) - light.cos_half_cone) * light.inverse_edge_width);
    return s;
}

// 1 where light i sees p, 0 where a surface hides it. n: the normal of the surface that p lies on, along
// which p is moved by the view's bias; 0 for a point in a medium.
float surface_visibility(int i, vec3 p, vec3 n)
{
#ifdef SURFACE_SHADOWS
    int view = int(u_lights.lights[i].first_view);
    if (i < SUN_COUNT) {
        // The inner view has the detail, the outer one holds everything.
        vec4 inner = u_lights.views[view].clip_from_world * vec4(p, 1.0);
        if (any(greaterThan(abs(inner.xy), vec2(1.0))))
            ++view;
    } else if (i < SUN_COUNT + POINT_COUNT) {
        view += cube_face(p - u_lights.lights[i].position);
    }
    ShadowView shadow = u_lights.views[view];
    p += n * shadow_bias(shadow.depth, p);
    vec4 clip = shadow.clip_from_world * vec4(p, 1.0);
    vec2 uv = clip.xy / clip.w * 0.5 + 0.5;
    return texture(u_shadow_map_tx, vec4(uv, float(view), shadow_depth(shadow.depth, p)));
#else
    return 1.0;
#endif
}

// The same in a medium, of what lies at uv, 0..1, and depth in a view.
float visibility_in(int view, vec2 uv, float depth)
{
#ifdef SURFACE_SHADOWS
    return texture(u_shadow_map_tx, vec4(uv, float(view), clamp(depth, 0.0, 1.0)));
#else
    return 1.0;
#endif
}

// Of a light that has a place, light.range metres along light.wi from p.
float placed_visibility(int i, vec3 p, LightSample light)
{
    int view = int(u_lights.lights[i].first_view);
    float depth = light.range * u_lights.views[view].depth.inverse_range;
    if (i < SUN_COUNT + POINT_COUNT) {
        int face;
        vec2 on_face = on_cube_face(-light.wi, face);
        return visibility_in(view + face, on_face * u_lights.lights[i].cube_view_scale + 0.5, depth);
    }
    vec4 clip = u_lights.views[view].clip_from_world * vec4(p, 1.0);
    return visibility_in(view, clip.xy / clip.w * 0.5 + 0.5, depth);
}
