// The extinction of the marched media at the nodes of a lattice, each the mean over its cell, so that what
// fills the other volumes fetches from one dense texture whatever the media are.
//   out  sigma_t [1/m]; its mean over the channels unless VOLUME_RGB
#include "lib/channels.glsl"
#include "scene/light_volumes.glsl"

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(binding = 0) writeonly uniform image3D u_extinction_img;

void main()
{
    ivec3 node = ivec3(gl_GlobalInvocationID);
    LatticeParams lattice = u_volumes.extinction;
    if (any(greaterThan(node, ivec3(lattice.last))))
        return;
    int n = u_volumes.samples;
    HeldMedia held = held_media();
    extinction_t sum = extinction_t(0.0);
    for (ivec3 place = ivec3(0); place.z < n; place = next_in_cell(place, n)) {
        vec3 in_cell = place_in_cell(place, n);
        sum += marched_extinction((lattice.world_from_node * vec4(vec3(node) + in_cell, 1.0)).xyz, held);
    }
    vec3 sigma_t = vec3(sum) / float(n * n * n);
#ifndef VOLUME_RGB
    sigma_t = vec3(mean(sigma_t));
#endif
    imageStore(u_extinction_img, node, vec4(sigma_t, 0.0));
}
