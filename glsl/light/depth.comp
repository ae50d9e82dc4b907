// Optical depth of the marched media from each node of a lattice to a light that has a place; a sun's is summed up in
// columns.comp. Depth and not transmittance is kept: it is smooth where the medium is, so that exp of what is
// interpolated errs least.
//   in   the extinction's volume, the light
//   out  optical depth, one layer of the texture
#include "light/trace.glsl"

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(binding = 0) writeonly uniform image3D u_depth_img;

void main()
{
    const float kMost = 6e4;  // of a 16-bit float; an infinity times a weight of 0 would be none
    ivec3 node = ivec3(gl_GlobalInvocationID) + ivec3(0, 0, u_volumes.first_slice);
    LatticeParams lattice = u_volumes.depth;
    if (any(greaterThan(node, ivec3(lattice.last))))
        return;
    int i = u_volumes.layer;
    // As fine as the nodes that are filled, and no coarser than those that it is filled from.
    float step = min(u_volumes.extinction.last.x / lattice.last.x, 1.0);
    vec3 p = node_position(lattice, node);
    vec3 to_light = u_volumes.light - p;
    float range = max(length(to_light), kLeastRange);
    vec3 wi = to_light / range;
    vec3 tau = min(vec3(traced_depth(p, wi, range, step)), vec3(kMost));
    imageStore(u_depth_img, node + ivec3(0, 0, i * (int(u_volumes.depth_period.z) + 1)), vec4(tau, 0.0));
}
