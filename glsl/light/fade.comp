// A mixture of light that was filled before and of what is filled now, at the nodes of the latter.
//   in   coefficients of both; alpha of the first: 0 in nodes inside of surfaces
//   out  the mixture's
#include "shared/light_fade_params.h"

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(std140, binding = LIGHT_FADE_BLOCK) uniform LightFade { LightFadeParams u_fade; };
layout(binding = FIELD_LIGHT_UNIT) uniform sampler3D u_before_tx;
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
    // Beyond the lattice that was there its faces have the nearest light.
    vec3 at = (u_fade.before_from_node * vec4(vec3(node), 1.0)).xyz;
    vec3 uvw = (clamp(at, vec3(0.0), u_fade.last_before) + 0.5) * u_fade.inverse_size;
    float a_layer = (u_fade.last_before.z + 1.0) * u_fade.inverse_size.z;
    float share = u_fade.share;
    // What lay inside of a surface had no light of its own.
    float seen = textureLod(u_before_tx, uvw, 0.0).a;
    float before = seen > 0.0 ? (1.0 - share) / seen : 0.0;
    share = seen > 0.0 ? share : 1.0;
    for (int i = 0; i < layers; ++i) {
        vec4 now = texelFetch(u_now_tx, node, 0);
        vec3 light = before * textureLod(u_before_tx, uvw, 0.0).rgb + share * now.rgb;
        imageStore(u_light_img, node, vec4(light, now.a));
        node.z += count.z;
        uvw.z += a_layer;
    }
}
