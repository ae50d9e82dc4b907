// One surface as a direction's columns meet it, a pixel a column: marks the ways between slices that it crosses, the
// way to the first slice as bit 0.
#include "light/field.glsl"

layout(r32ui, binding = 0) uniform uimage3D u_crossed_img;
in vec3 p_world;

void main()
{
    FieldDirection d = u_field.directions[0];
    float last = to_axes(d.axis, u_field.nodes.last).x;
    float along = to_axes(d.axis, (u_field.nodes.node_from_world * vec4(p_world, 1.0)).xyz).x;
    float slice = max(ceil(d.forward > 0.0 ? along : last - along), 0.0);
    if (slice > last)
        return;
    int to = int(slice);
    imageAtomicOr(u_crossed_img, ivec3(gl_FragCoord.xy, d.first_word + (to >> 5)), 1u << uint(to & 31));
}
