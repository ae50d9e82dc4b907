// What the drawing of surfaces along the axes has kept for each node, as it is looked up.
//   in   light/steps.glsl
//   out  lib/walls.glsl: all axes in a texel
#include "light/steps.glsl"

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(rgba16f, binding = 0) writeonly uniform image3D u_walls_img;

void main()
{
    ivec3 node = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(node, node_count())))
        return;
    for (int up = 0; up < 2; ++up)
        imageStore(u_walls_img, node + layer_of(up),
                   vec4(steps_to(node, up), steps_to(node, 2 + up), steps_to(node, 4 + up), 0.0));
}
