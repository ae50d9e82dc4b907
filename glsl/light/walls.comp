// What the drawing of surfaces along the axes has kept for each node, as it is looked up.
//   in   from each node to the nearest surface, in WALL_STEPS of the way to the next node: two layers an axis, down, up
//        kDims: the media's extinction
//   out  lib/walls.glsl: all axes in a texel; alpha: what media let through over two nodes
#include "light/field.glsl"

const bool kDims = false;  // variant

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(binding = FIELD_SIGMA_T_UNIT) uniform sampler3D u_sigma_t_tx;
layout(rgba16f, binding = 0) writeonly uniform image3D u_walls_img;

float steps_to(ivec3 node, int layer)
{
    uint steps = texelFetch(u_crossed_tx, node + layer_of(layer), 0).r;
    return steps > uint(WALL_STEPS) ? 2.0 : float(steps) / float(WALL_STEPS);
}

void main()
{
    ivec3 node = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(node, node_count())))
        return;
    float through = 1.0;
    if (kDims) {
        vec3 sigma_t = texelFetch(u_sigma_t_tx, node, 0).rgb;
        through = exp(-2.0 * u_field.nodes.spacing * max(sigma_t.r, max(sigma_t.g, sigma_t.b)));
    }
    for (int up = 0; up < 2; ++up)
        imageStore(u_walls_img, node + layer_of(up),
                   vec4(steps_to(node, up), steps_to(node, 2 + up), steps_to(node, 4 + up), through));
}
