// A surface as the lines along ways of a batch meet it: each instance is of one way, a line a pixel. z grows from slice
// to slice; all that may hide the world from the first is held, and what lies behind the last is clipped, as are the
// pixels beyond the way's own lines: there are as many for all ways as the one with the most has.
#include "light/line.glsl"
#include "shared/draw_params.h"

layout(std140, binding = DRAW_BLOCK) uniform Draw { DrawParams u_draw; };
layout(location = 0) in vec3 in_position;
layout(location = 1) in vec3 in_normal;
out vec3 p_world;
out vec3 normal;  // scaled evenly or along its axes alone, so it needs no other matrix
flat out int k;   // of the way
out float gl_ClipDistance[3];

void main()
{
    const float kFarthest = 1e6;  // slices
    k = gl_InstanceID;
    FieldWay way = u_field.ways[k];
    p_world = (u_draw.world_from_object * vec4(in_position, 1.0)).xyz;
    normal = in_normal;
    vec3 q = along_axes(way.axis, node_at(u_field.nodes, p_world));
    float last = along_axes(way.axis, u_field.nodes.last).x;
    float slice = way.forward > 0.0 ? q.x : last - q.x;
    vec2 line = q.yz - way.slope * slice - u_field.tilt * (slice - 0.5 * last) - vec2(way.first_line);
    vec2 own = along_axes(way.axis, u_field.nodes.last).yz + ceil(abs(way.slope) * last) + 4.0;
    for (int i = 0; i < 2; ++i)
        gl_ClipDistance[i] = own[i] - line[i] - 0.5;
    gl_ClipDistance[2] = line.x + 0.5;
    line.x += float(first_pixel(k));
    gl_Position =
        vec4(2.0 * (line + 0.5) / vec2(u_field.lines) - 1.0, 1.0 - 2.0 * (last + 1.0 - slice) / kFarthest, 1.0);
}
