// Light that a medium scatters towards the eye at a point: every light and the world, once.
//
// Variant, besides those of scene/light_volumes.glsl:
//   VOLUME_SHADOWS   media dim the light on its way to the point
//   WORLD_LIGHT      the world's light scatters too: its mean radiance, undimmed, isotropically, unless
//                    there is a WORLD_VOLUME
//   ISOTROPIC        no medium has g
//   LIGHT_DEPTH      a function of a light's number, the point and its LightSample: the media's optical
//                    depth between, if not that of the media themselves
#include "lib/phase.glsl"
#include "scene/frame.glsl"
#include "scene/light_volumes.glsl"

#ifndef LIGHT_DEPTH
#define LIGHT_DEPTH depth_to_light
#endif

float phase_of(LightSample light, vec3 wo, float g)
{
#ifdef ISOTROPIC
    return phase_isotropic();
#else
    float g_clamp = u_frame.resolve.z;
    return phase_henyey_greenstein(dot(-light.wi, wo), clamp(g, -g_clamp, g_clamp));
#endif
}

// Radiance scattered towards the eye at p, per metre of ray and unit of sigma_s. wo: unit length, to the eye.
vec3 in_scattering_at(vec3 p, vec3 wo, float g)
{
    vec3 in_scattering = vec3(0.0);
#if defined(WORLD_VOLUME)
    in_scattering += world_in_scattering(p, g);
#elif defined(WORLD_LIGHT)
    in_scattering += u_lights.world_radiance.rgb;  // 4 pi sr of it, times the isotropic 1 / (4 pi)
#endif
    for (int i = 0; i < LIGHT_COUNT; ++i) {
        LightSample light = light_sample(i, p);
        if (light.irradiance == vec3(0.0))  // outside a spot's cone
            continue;
        float visibility = surface_visibility(i, p, vec3(0.0));
        if (visibility == 0.0)
            continue;
        vec3 arriving = light.irradiance * (visibility * phase_of(light, wo, g));
#ifdef VOLUME_SHADOWS
        arriving *= exp(-LIGHT_DEPTH(i, p, light));
#endif
        in_scattering += arriving;
    }
    return in_scattering;
}
