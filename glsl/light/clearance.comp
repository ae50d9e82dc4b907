// Of each node its clearance, an axis a pass.
//   in   the surfaces' walls; from the second pass on, what the pass before gave
//   out  nodes, CLEARANCE_MOST at most; of the last axis, light/clearance.glsl
#include "light/field.glsl"
#include "light/clearance.glsl"

// Variant
const int kAxis = 0;

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(binding = WALLS_UNIT) uniform sampler3D u_walls_tx;
layout(binding = 0) writeonly uniform uimage3D u_clearance_img;

int nodes_to_wall(ivec3 node)
{
    if (kAxis > 0)
        return int(texelFetch(u_crossed_tx, node, 0).r);
    Walls walls = walls_of(u_walls_tx, node, node_count().z);
    return any(lessThanEqual(min(walls.down, walls.up), vec3(1.0))) ? 0 : CLEARANCE_MOST;
}

void main()
{
    ivec3 node = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(node, node_count())))
        return;
    int least = nodes_to_wall(node);
    for (int i = 1; i < least; ++i)
        for (int side = -1; side <= 1; side += 2) {
            ivec3 next = node;
            next[kAxis] += side * i;
            if (next[kAxis] >= 0 && next[kAxis] < node_count()[kAxis])
                least = min(least, max(i, nodes_to_wall(next)));
        }
    uvec2 texel = uvec2(uint(least), 0u);
    if (kAxis == 2)
        texel = pack_clearance(walls_of(u_walls_tx, node, node_count().z), least);
    imageStore(u_clearance_img, node, uvec4(texel, 0u, 0u));
}
