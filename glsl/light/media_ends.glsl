// Ways that lie in the plane of a face at which a medium ends, with all of its density.
//
// A way stands for the directions around it. Along one that is parallel to a face light goes through the medium, however
// near to the face it does, but half of the directions around come from beyond the face, through as little of the medium
// as lies between. They are spread evenly over the cosines to the face that are left to them, up to u_field.in_plane.
#include "light/field.glsl"
#include "lib/channels.glsl"

// What of the light along a way is that of directions which come from beyond faces.
struct Beyond {
    float within;  // what is left of the light that goes through the medium all along
    float open;    // what there is of the light outside
};

// The mean of exp(-depth / mu) over mu in 0..1 is E2(depth), whose integral is -E3: to 2 % of 1.
float dimmed_at(float depth) { return exp(-depth) / (1.0 + 1.5 * depth); }
float dimmed_beyond(float depth) { return exp(-depth) / (2.0 + 1.36 * depth); }

// For a node, at which the medium has `sigma_t`, and light has gone `gone` metres through the lattice.
//   reach  0: at the node; 1: the mean over what lies between it and its neighbours
//   open   of what lies beyond, lower and higher along the next axis after the way's and the one after it
Beyond beyond_ends(ivec3 node, FieldWay way, extinction_t sigma_t, float gone, float reach, vec4 open)
{
    vec2 left = vec2(1.0);
    float inverse_length = mean(sigma_t) + 1.0 / max(gone, 0.5 * way.metres);
    for (int i = 0; i < 4; ++i) {
        int axis = (way.axis + 1 + (i >> 1)) % 3;
        float nodes =
            (i & 1) == 0 ? float(node[axis]) - u_field.ends_low[axis] : u_field.ends_high[axis] - float(node[axis]);
        if (way.slope[i >> 1] != 0.0 || nodes < -0.5)
            continue;
        float scale = inverse_length * length(u_field.nodes.world_from_node[axis].xyz) / u_field.in_plane;
        float near = max(max(nodes, 0.0) - reach, 0.0) * scale;
        float far = (max(nodes, 0.0) + reach) * scale;
        float dimmed = far - near < 1e-3 ? dimmed_at(near) : (dimmed_beyond(near) - dimmed_beyond(far)) / (far - near);
        left *= 1.0 - 0.5 * dimmed * vec2(1.0, open[i]);
    }
    return Beyond(left.x, 1.0 - left.y);
}
