// Surfaces: radiance albedo / pi * irradiance + emission; GLOSSY ones reflect by the layer of lib/ggx.glsl over that.
#include "shared/bindings.h"
#include "shared/draw_params.h"

layout(std140, binding = DRAW_BLOCK) uniform Draw { DrawParams u_draw; };
#include "scene/irradiance.glsl"

const bool kTwoSided = false;  // variant

in vec3 p_world;
in vec3 normal;
layout(location = 0) out vec4 out_color;

void main()
{
    vec3 n = normalize(normal);
    if (kTwoSided && !gl_FrontFacing)
        n = -n;
#ifdef GLOSSY
    begin_gloss(n);
    vec3 base = ggx_base(u_draw.albedo, u_draw.metallic, gloss.f0, gloss.ab) / kPi * irradiance_at(p_world, n);
    out_color = vec4(base + reflected + u_draw.emission, 1.0);
#else
    out_color = vec4(u_draw.albedo / kPi * irradiance_at(p_world, n) + u_draw.emission, 1.0);
#endif
}
