// Adds light that another lattice has at the places of this one's nodes.
//   in   its coefficients; alpha of the first: 0 in nodes inside of surfaces, which are left out of the mean of eight;
//        and the walls between its nodes: those behind a surface are left out too
//   out  ours
#include "light/field.glsl"
#include "shared/spherical_harmonics.h"

const int kBands = 1;  // variant

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(rgba32f, binding = 0) uniform image3D u_light_img;
layout(binding = FIELD_LIGHT_UNIT) uniform sampler3D u_other_tx;
layout(binding = WALLS_UNIT) uniform sampler3D u_walls_tx;

void main()
{
    ivec3 node = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(node, node_count())))
        return;
    LatticeParams other = u_field.other;
    Walls walls;
    vec3 q = node_at(other, node_position(u_field.nodes, node));
    vec3 uvw = (on_own_side(u_walls_tx, ivec3(0), other.last, q, walls) + 0.5) * other.inverse_size;
    float seen = textureLod(u_other_tx, uvw, 0.0).a;
    if (seen == 0.0)
        return;
    for (int i = 0; i < kHarmonics[kBands - 1]; ++i) {
        ivec3 at = node + layer_of(i);
        vec3 light = textureLod(u_other_tx, in_layer(other, uvw, i), 0.0).rgb / seen;
        vec4 own = imageLoad(u_light_img, at);
        imageStore(u_light_img, at, vec4(own.rgb + light, i == 0 ? 1.0 : 0.0));
    }
}
