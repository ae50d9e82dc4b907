// Lambertian surfaces: radiance albedo / pi * (irradiance of all lights + the world's), light hidden by
// surfaces and, THROUGH_MEDIA, dimmed by the media on its way.
//   ENVIRONMENT       the world is a map: irradiance by normal from a table, else pi * its one colour
//   WORLD_IRRADIANCE  what of it is hidden and dimmed is in a volume
#include "lib/lattice.glsl"
#include "lib/phase.glsl"
#include "scene/frame.glsl"
#include "scene/light_volumes_block.glsl"
#include "scene/lights.glsl"
#ifdef THROUGH_MEDIA
#include "scene/light_volumes.glsl"
#endif
#ifdef WORLD_IRRADIANCE
#include "scene/world_irradiance.glsl"
#endif
#include "shared/draw_params.h"

layout(std140, binding = DRAW_BLOCK) uniform Draw { DrawParams u_draw; };
#ifdef ENVIRONMENT
#include "lib/lat_long.glsl"
layout(binding = IRRADIANCE_UNIT) uniform sampler2D u_irradiance_tx;
#endif
in vec3 p_world;
in vec3 normal;
layout(location = 0) out vec4 out_color;

void main()
{
    vec3 n = normalize(normal);
#ifdef TWO_SIDED
    if (!gl_FrontFacing)
        n = -n;
#endif
#ifdef ENVIRONMENT
    vec3 irradiance = textureLod(u_irradiance_tx, lat_long_uv(n), 0.0).rgb;
#else
    vec3 irradiance = kPi * u_lights.world_radiance.rgb;
#endif
#ifdef WORLD_IRRADIANCE
    irradiance = world_irradiance(p_world, n, irradiance);
#endif
    for (int i = 0; i < LIGHT_COUNT; ++i) {
        LightSample light = light_sample(i, p_world);
        float cos_theta = dot(n, light.wi);
        if (cos_theta <= 0.0 || light.irradiance == vec3(0.0))
            continue;
        float visibility = surface_visibility(i, p_world, n);
        if (visibility == 0.0)
            continue;
        vec3 arriving = light.irradiance * (visibility * cos_theta);
#ifdef THROUGH_MEDIA
        arriving *= exp(-depth_to_light(i, p_world, light));
#endif
        irradiance += arriving;
    }
    out_color = vec4(u_draw.albedo.rgb / kPi * irradiance, 1.0);
}
