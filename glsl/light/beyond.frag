// One surface beyond the lattice as the lines along a way meet it before they enter: what it sends along them, of
// lights and of the world; alpha: metres to the node that it enters at.
#include "light/line.glsl"
#include "light/dimmed_lights.glsl"
#define OWN_THROUGH_MEDIA
#include "scene/irradiance.glsl"
#include "shared/draw_params.h"

layout(std140, binding = DRAW_BLOCK) uniform Draw { DrawParams u_draw; };
in vec3 p_world;
in vec3 normal;
layout(location = 0) out vec4 out_light;

void main()
{
    FieldWay way = u_field.ways[0];
    Meeting meeting = meeting_at(way, p_world, ivec2(gl_FragCoord.xy));
    if (!meeting.beyond || !meeting.is_met)
        discard;
    vec3 n = normalize(normal);
    bool is_inside = dot(n, way.wi) > 0.0;
    out_light = vec4(0.0, 0.0, 0.0, max(meeting.before, 0.0) * way.metres);
    if (is_inside && u_draw.is_open == 0)
        return;
    if (is_inside)
        n = -n;
    out_light.rgb = u_draw.emission + u_draw.albedo / kPi * irradiance_at(p_world, n);
}
