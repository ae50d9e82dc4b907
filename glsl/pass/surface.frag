// Lambertian surfaces: radiance albedo / pi * irradiance.
#include "scene/irradiance.glsl"
#include "shared/draw_params.h"

const bool kTwoSided = false;  // variant

layout(std140, binding = DRAW_BLOCK) uniform Draw { DrawParams u_draw; };
in vec3 p_world;
in vec3 normal;
layout(location = 0) out vec4 out_color;

void main()
{
    vec3 n = normalize(normal);
    if (kTwoSided && !gl_FrontFacing)
        n = -n;
    out_color = vec4(u_draw.albedo.rgb / kPi * irradiance_at(p_world, n), 1.0);
}
