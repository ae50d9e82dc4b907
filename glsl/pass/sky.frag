// The world seen directly, where no surface is.
#include "lib/lat_long.glsl"
#include "scene/frame.glsl"
#include "shared/light_params.h"

const bool kEnvironment = false;  // variant: the world is a map

layout(binding = ENVIRONMENT_UNIT) uniform sampler2D u_environment_tx;
layout(std140, binding = LIGHTS_BLOCK) uniform Lights { LightsParams u_lights; };
layout(location = 0) out vec4 out_color;

void main()
{
    out_color = vec4(u_lights.world_radiance.rgb, 1.0);
    if (!kEnvironment)
        return;
    Ray ray = camera_ray(gl_FragCoord.xy * u_frame.inverse_full_size * 2.0 - 1.0);
    out_color = vec4(textureLod(u_environment_tx, lat_long_uv(normalize(ray.direction)), 0.0).rgb, 1.0);
}
