// How far a node sees on each side of it, as surfaces look it up.
//   in   light/steps.glsl; coefficients of light, alpha of the first: 0 inside of surfaces; kDims: the media's extinction
//   out  lib/sights.glsl: an octant a layer
#include "light/field_listed.glsl"
#include "light/steps.glsl"
#include "lib/channels.glsl"
#include "lib/sights.glsl"

const bool kDims = false;  // variant

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(binding = FIELD_SIGMA_T_UNIT) uniform sampler3D u_sigma_t_tx;
layout(binding = WORLD_ON_SURFACES_UNIT) uniform sampler3D u_light_tx;
layout(binding = 0) writeonly uniform uimage3D u_sights_img;

void main()
{
    ivec3 node = own_node();
    if (any(greaterThanEqual(node, node_count())))
        return;
    float through = 1.0;
    if (kDims) {
        vec3 sigma_t = texelFetch(u_sigma_t_tx, node, 0).rgb;
        through = exp(-2.0 * u_field.nodes.spacing * most(sigma_t));
    }
    float steps[kSteps];
    // The node lies inside of a surface if most of those around it are seen from within. What its light tells of it is
    // coarser, as lines go past a node at up to half the way to the next.
    int within = 0;
    for (int way = 0; way < kSteps; ++way) {
        uint word = word_to(node, way);
        steps[way] = steps_of(word);
        if (is_near(word))
            within += (word & 1u) == 1u ? 1 : -1;
    }
    float outside = within > 0 ? 0.0 : texelFetch(u_light_tx, node, 0).a;
    for (int octant = 0; octant < 8; ++octant) {
        ivec3 up = ivec3(octant & 1, octant >> 1 & 1, octant >> 2);
        Sight sight;
        for (int axis = 0; axis < 3; ++axis) {
            int i = (axis + 1) % 3, j = (axis + 2) % 3;
            sight.axes[axis] = steps[2 * axis + up[axis]];
            sight.faces[axis] = steps[6 + 4 * axis + up[i] + 2 * up[j]];
            sight.behind[axis] = step(1.0001, steps[2 * axis + 1 - up[axis]]);
        }
        sight.middle = steps[18 + octant];
        sight.through = through;
        sight.outside = outside;
        imageStore(u_sights_img, node + layer_of(octant), uvec4(pack_sight(sight), 0u, 0u));
    }
}
