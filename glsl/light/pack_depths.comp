// Optical depths towards up to four lights, a texel each, into the channels of one: lights that have places share the
// lattice, and a sample that is lit by many of them pays one fetch for four.
//   in   depths, a layer a light
//   out  a layer of the packed ones
#include "scene/light_volumes_block.glsl"

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(binding = DEPTH_VOLUME_UNIT) uniform sampler3D u_depth_volume_tx;
layout(binding = 0) writeonly uniform image3D u_packed_img;

void main()
{
    ivec3 texel = ivec3(gl_GlobalInvocationID), size = ivec3(u_volumes.depth_period) + 1;
    if (any(greaterThanEqual(texel, size)))
        return;
    vec4 depths = vec4(0.0);
    for (int k = 0; k < u_volumes.samples; ++k)
        depths[k] = texelFetch(u_depth_volume_tx, texel + ivec3(0, 0, (u_volumes.first_slice + k) * size.z), 0).r;
    imageStore(u_packed_img, texel + ivec3(0, 0, u_volumes.layer * size.z), depths);
}
