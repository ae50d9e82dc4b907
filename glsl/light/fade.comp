// A mixture of light that was filled before and of what is filled now, at the nodes of the latter.
//   in   coefficients of both; alpha of the first: 0 in nodes inside of surfaces
//   out  the mixture's
#include "light/fade.glsl"

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(binding = FIELD_WORLD_UNIT) uniform sampler3D u_now_tx;
layout(rgba16f, binding = 0) writeonly uniform image3D u_light_img;

void main()
{
    ivec3 node = ivec3(gl_GlobalInvocationID);
    ivec3 count = imageSize(u_light_img);
    int layers = u_fade.layers;
    count.z /= layers;
    if (any(greaterThanEqual(node, count)))
        return;
    Fade fade = fade_at(node);
    for (int i = 0; i < layers; ++i) {
        vec4 now = texelFetch(u_now_tx, node, 0);
        imageStore(u_light_img, node, vec4(next_faded(fade, now.rgb), now.a));
        node.z += count.z;
    }
}
