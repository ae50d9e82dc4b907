// What surfaces cross, as it is drawn (light/crossed.frag), side by side: what is asked of a node along a way is then one
// texel.
//   out  for each node and 32 ways a bit a way: a surface lies before it, each of two lines meets one beyond the lattice,
//        the surface's solid is left there
#include "light/field.glsl"

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(binding = 0) writeonly uniform uimage3D u_crossings_img;

void main()
{
    ivec3 node = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(node, node_count())))
        return;
    for (int word = 0; word < u_field.count; ++word) {
        uvec4 bits = uvec4(0u);
        for (int part = 0; part < 4; ++part)
            bits[part] = texelFetch(u_crossed_tx, node + layer_of(part * FIELD_CROSSED_WORDS + word), 0).x;
        imageStore(u_crossings_img, node + layer_of(word), bits);
    }
}
