// A ray through a lattice, from a node to the first surface that it meets.
#include "light/field.glsl"
#include "light/clearance.glsl"

struct Met {
    ivec3 node;  // the node that is nearest to where that is
    int layer;   // of its faces; -1: none is met within the lattice
    float t;     // metres that the ray has gone
};

// A course that is along none of the axes' planes.
vec3 off_axes(vec3 course)
{
    return mix(course, mix(vec3(-1e-6), vec3(1e-6), greaterThan(course, vec3(0.0))), lessThan(abs(course), vec3(1e-6)));
}

// The way is followed from node to node, each the nearest: Amanatides and Woo 1987, "A Fast Voxel Traversal Algorithm for
// Ray Tracing"; at once as far as there is no surface.
//   course  of one metre, in nodes; off_axes()
//   most    metres that are asked about
Met first_met(ivec3 from, vec3 course, float most)
{
    vec3 inverse = 1.0 / course;
    bvec3 is_up = greaterThan(course, vec3(0.0));
    ivec3 ahead = ivec3(sign(course));
    ivec3 node = from;
    float t = 0.0;
    while (t < most && all(lessThan(uvec3(node), uvec3(node_count())))) {
        Clearance clear = unpack_clearance(texelFetch(u_crossed_tx, node, 0).rg, is_up);
        int steps = max(clear.nodes, 1);
        bvec3 stands = lessThanEqual(clear.wall, vec3(1.0));
        vec3 ends = (vec3(node - from) + vec3(ahead) * mix(vec3(float(steps) - 0.5), clear.wall, stands)) * inverse;
        float end = min(ends.x, min(ends.y, ends.z));
        // An axis alone, by a mask: an index would send a CPU's registers by way of memory.
        bvec3 is_end = equal(ends, vec3(end));
        ivec3 axis = is_end.x ? ivec3(1, 0, 0) : is_end.y ? ivec3(0, 1, 0) : ivec3(0, 0, 1);
        t = max(t, end);
        if (any(notEqual(axis * ivec3(stands), ivec3(0))))
            return Met(node, axis.y * 2 + axis.z * 4 + (any(notEqual(axis * ivec3(is_up), ivec3(0))) ? 1 : 0), t);
        ivec3 next = node + axis * ahead * steps;
        if (steps > 1) {
            // Never back: where two axes end at once it would be by turns.
            ivec3 past = from + ivec3(floor(course * t + 0.5));
            node = mix(min(node, past), max(node, past), is_up);
        }
        node = mix(node, next, equal(axis, ivec3(1)));
    }
    return Met(node, -1, t);
}
