// How far a node sees on each side of it, as surfaces look it up.
//   in   light/steps.glsl; coefficients of light, alpha of the first: 0 inside of surfaces; kDims: the media's extinction
//   out  lib/sights.glsl: an octant a layer
#include "light/steps.glsl"
#include "lib/sights.glsl"

const bool kDims = false;  // variant

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(binding = FIELD_SIGMA_T_UNIT) uniform sampler3D u_sigma_t_tx;
layout(binding = WORLD_ON_SURFACES_UNIT) uniform sampler3D u_light_tx;
layout(binding = 0) writeonly uniform uimage3D u_sights_img;

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
    float outside = is_inside(node) ? 0.0 : texelFetch(u_light_tx, node, 0).a;
    for (int octant = 0; octant < 8; ++octant) {
        ivec3 up = ivec3(octant & 1, octant >> 1 & 1, octant >> 2);
        Sight sight;
        for (int axis = 0; axis < 3; ++axis) {
            int i = (axis + 1) % 3, j = (axis + 2) % 3;
            sight.axes[axis] = steps_to(node, 2 * axis + up[axis]);
            sight.faces[axis] = steps_to(node, 6 + 4 * axis + up[i] + 2 * up[j]);
            sight.behind[axis] = step(1.0001, steps_to(node, 2 * axis + 1 - up[axis]));
        }
        sight.middle = steps_to(node, 18 + octant);
        sight.through = through;
        sight.outside = outside;
        imageStore(u_sights_img, node + layer_of(octant), uvec4(pack_sight(sight), 0u, 0u));
    }
}
