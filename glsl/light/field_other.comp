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

// What goes from node to node of the other lattice is dimmed in between, by ever so much a metre: the mean of its
// logarithms is nearer to what is there than that of the numbers, which is too much. Of the latter it is this part.
//   q  in nodes
vec3 part_of_mean(vec3 q)
{
    const float kLeast = 1e-3;  // of the most: what is darker may be rounded
    vec3 base = clamp(floor(q), vec3(0.0), u_field.other.last - 1.0);
    vec3 t = clamp(q - base, 0.0, 1.0);
    vec4 corners[8];
    vec3 most = vec3(0.0);
    for (int i = 0; i < 8; ++i) {
        ivec3 corner = ivec3(i & 1, i >> 1 & 1, i >> 2);
        vec3 share = mix(1.0 - t, t, vec3(corner));
        vec4 there = texelFetch(u_other_tx, ivec3(base) + corner, 0);
        corners[i] = vec4(there.rgb, share.x * share.y * share.z * step(0.5, there.a));
        most = max(most, corners[i].rgb);
    }
    vec3 mean = vec3(0.0);
    vec3 logarithms = vec3(0.0);
    float shares = 0.0;
    for (int i = 0; i < 8; ++i) {
        mean += corners[i].a * corners[i].rgb;
        logarithms += corners[i].a * log(max(corners[i].rgb, kLeast * most + 1e-30));
        shares += corners[i].a;
    }
    return shares > 0.0 ? min(exp(logarithms / shares) * shares / max(mean, vec3(1e-30)), vec3(1.0)) : vec3(1.0);
}

void main()
{
    ivec3 node = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(node, node_count())))
        return;
    LatticeParams other = u_field.other;
    Walls walls;
    vec3 q = node_at(other, node_position(u_field.nodes, node));
    vec3 place = on_own_side(u_walls_tx, ivec3(0), other.last, q, walls);
    vec3 uvw = (place + 0.5) * other.inverse_size;
    float seen = textureLod(u_other_tx, uvw, 0.0).a;
    if (seen == 0.0)
        return;
    vec3 part = part_of_mean(place);
    for (int i = 0; i < kHarmonics[kBands - 1]; ++i) {
        ivec3 at = node + layer_of(i);
        vec3 light = textureLod(u_other_tx, in_layer(other, uvw, i), 0.0).rgb * part / seen;
        vec4 own = imageLoad(u_light_img, at);
        imageStore(u_light_img, at, vec4(own.rgb + light, i == 0 ? 1.0 : 0.0));
    }
}
