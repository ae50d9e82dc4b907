// A surface of the scene: positions and normals of its mesh to eye-centred world and to clip space.
#include "shared/bindings.h"
#include "shared/draw_params.h"

layout(std140, binding = DRAW_BLOCK) uniform Draw { DrawParams u_draw; };
layout(location = 0) in vec3 in_position;
layout(location = 1) in vec3 in_normal;
out vec3 p_world;
out vec3 normal;  // scaled evenly or along its axes alone, so it needs no other matrix

void main()
{
    p_world = (u_draw.world_from_object * vec4(in_position, 1.0)).xyz;
    normal = in_normal;
    gl_Position = u_draw.clip_from_object * vec4(in_position, 1.0);
}
