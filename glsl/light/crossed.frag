// One surface as the lines along a way meet it, a pixel a line: marks the node that each line comes to next.
// What lies beyond the lattice hides the line's first node.
#include "light/field.glsl"

// Variant
const bool kBeyond = false;  // what lies beyond the lattice is asked for, else what lies in it

layout(r32ui, binding = 0) uniform uimage3D u_crossed_img;
in vec3 p_world;

bool is_within(FieldWay way, ivec2 start, int slice, ivec3 last)
{
    ivec2 across = start + across_at(way, slice);
    return all(greaterThanEqual(across, ivec2(0))) && all(lessThanEqual(across, last.yz));
}

void main()
{
    FieldWay way = u_field.ways[0];
    ivec3 last = to_axes(way.axis, node_count()) - 1;
    vec3 q = (u_field.nodes.node_from_world * vec4(p_world, 1.0)).xyz;
    // A node that lies on a surface is behind it from both sides, whatever rounding says.
    const float kNear = 1e-3;
    bool beyond = any(lessThan(q, vec3(-2.0 * kNear))) || any(greaterThan(q, u_field.nodes.last + 2.0 * kNear));
    if (beyond != kBeyond)
        return;
    float along = way.axis == 0 ? q.x : way.axis == 1 ? q.y : q.z;
    if (way.forward < 0.0)
        along = float(last.x) - along;
    ivec2 start = ivec2(gl_FragCoord.xy) + u_field.columns;
    // The first slice in which the line is in the lattice, to within one for rounding.
    int to = 0;
    for (int i = 0; i < 2; ++i) {
        float s = way.slope[i];
        if (s != 0.0)
            to = max(to, int(ceil((s > 0.0 ? -0.5 - float(start[i]) : 0.5 + float(last[i + 1] - start[i])) / s)) - 1);
    }
    to = clamp(to, 0, last.x);
    if (!is_within(way, start, to, last))
        ++to;
    if (!is_within(way, start, to, last))
        ++to;
    to = max(to, int(ceil(clamp(along - kNear, -1.0, float(last.x) + 1.0))));
    if (to > last.x || !is_within(way, start, to, last))
        return;
    ivec2 across = start + across_at(way, to);
    ivec3 node = from_axes(way.axis, ivec3(way.forward > 0.0 ? to : last.x - to, across));
    imageAtomicOr(u_crossed_img, node + layer_of(u_field.first >> 5), 1u << uint(u_field.first & 31));
}
