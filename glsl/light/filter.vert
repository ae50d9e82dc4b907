// A transparent that casts: positions of its mesh to a light's space and to clip space.
#include "shared/bindings.h"
#include "shared/light_filter_params.h"

layout(std140, binding = DRAW_BLOCK) uniform Draw { LightFilterDrawParams u_draw; };
layout(location = 0) in vec3 in_position;  // of a quad 0..1, its lower left at 0
out vec3 p_light;                          // light-centred metres
out vec2 uv;

void main()
{
    p_light = (u_draw.light_from_object * vec4(in_position, 1.0)).xyz;
    uv = in_position.xy;
    gl_Position = u_draw.clip_from_object * vec4(in_position, 1.0);
}
