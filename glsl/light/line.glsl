// The lines along a way as surfaces are drawn along them, a pixel a line.
#include "light/field.glsl"

// A software rasteriser's threads take squares of 64 pixels each, and the lines of most lattices lie within one: those
// of other ways have others.
int first_pixel(int way) { return way % FIELD_WAYS_BESIDE * u_field.apart; }

bool is_within(FieldWay way, ivec2 start, int slice, ivec3 last)
{
    ivec2 across = start + across_at(way, slice);
    return all(greaterThanEqual(across, ivec2(0))) && all(lessThanEqual(across, last.yz));
}

// A place where the line of a pixel meets a surface, and the node that the line comes to next.
struct Meeting {
    bool beyond;  // the place lies beyond the lattice
    bool is_met;  // there is such a node: else the line has left the lattice, or never enters it
    ivec3 node;
    float before;  // it, in slices
};

// p: eye-centred metres
Meeting meeting_at(FieldWay way, vec3 p, ivec2 pixel)
{
    Meeting meeting = Meeting(false, false, ivec3(0), 0.0);
    ivec3 last = to_axes(way.axis, node_count()) - 1;
    vec3 q = (u_field.nodes.node_from_world * vec4(p, 1.0)).xyz;
    // A node that lies on a surface is behind it from both sides, whatever rounding says.
    const float kNear = 1e-3;
    meeting.beyond = any(lessThan(q, vec3(-2.0 * kNear))) || any(greaterThan(q, u_field.nodes.last + 2.0 * kNear));
    float along = along_axes(way.axis, q).x;
    if (way.forward < 0.0)
        along = float(last.x) - along;
    ivec2 start = pixel + way.first_line;
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
    meeting.is_met = to <= last.x && is_within(way, start, to, last);
    meeting.node = from_axes(way.axis, ivec3(way.forward > 0.0 ? to : last.x - to, start + across_at(way, to)));
    meeting.before = float(to) - along;
    return meeting;
}
