// One surface as the lines along a way meet it, a pixel a line: marks the node that each line comes to next.
// What lies beyond the lattice hides the line's first node.
#include "light/field.glsl"

// Variant
const bool kBeyond = false;  // what lies beyond the lattice is asked for, else what lies in it
const bool kWalls = false;   // how far before the node it lies is kept instead, along an axis of the lattice

layout(r32ui, binding = 0) uniform uimage3D u_crossed_img;
in vec3 p_world;
in vec3 normal;

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
    if (kWalls) {
        float before = float(to) - along;
        if (before <= 1.0)
            imageAtomicMin(u_crossed_img, node + layer_of(u_field.first), uint(max(before, 0.0) * float(WALL_STEPS)));
        return;
    }
    ivec3 word = node + layer_of(u_field.first >> 5);
    uint bit = 1u << uint(u_field.first & 31);
    imageAtomicOr(u_crossed_img, word, bit);
    if (!kBeyond && dot(normal, way.wi) < 0.0)  // light goes the other way
        imageAtomicOr(u_crossed_img, word + layer_of(3 * FIELD_CROSSED_WORDS), bit);
}
