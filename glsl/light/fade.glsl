// Light that fades from what was filled before to what is filled now.
#include "shared/light_fade_params.h"

const bool kStays = false;  // variant: both were filled at the same nodes

layout(std140, binding = LIGHT_FADE_BLOCK) uniform LightFade { LightFadeParams u_fade; };
layout(binding = FIELD_LIGHT_UNIT) uniform sampler3D u_before_tx;

// Where a node is in the first layer of what was filled before, and how much of both it has.
struct Fade {
    vec3 uvw;
    float a_layer;  // of uvw.z
    ivec3 node;
    int nodes_a_layer;
    float before, now;
};

Fade fade_at(ivec3 node)
{
    Fade fade;
    // Beyond the lattice that was there its faces have the nearest light.
    vec3 at = (u_fade.before_from_node * vec4(vec3(node), 1.0)).xyz;
    fade.uvw = (clamp(at, vec3(0.0), u_fade.last_before) + 0.5) * u_fade.inverse_size;
    fade.nodes_a_layer = int(u_fade.last_before.z) + 1;
    fade.a_layer = float(fade.nodes_a_layer) * u_fade.inverse_size.z;
    fade.node = node;
    // Nodes inside of a surface had no light of their own.
    float seen = kStays ? texelFetch(u_before_tx, node, 0).a : textureLod(u_before_tx, fade.uvw, 0.0).a;
    fade.now = seen > 0.0 ? u_fade.share : 1.0;
    fade.before = seen > 0.0 ? (1.0 - u_fade.share) / seen : 0.0;
    return fade;
}

// From one layer to the next: what `now` has there and what was there before.
vec3 next_faded(inout Fade fade, vec3 now)
{
    vec3 before = kStays ? texelFetch(u_before_tx, fade.node, 0).rgb : textureLod(u_before_tx, fade.uvw, 0.0).rgb;
    fade.node.z += fade.nodes_a_layer;
    fade.uvw.z += fade.a_layer;
    return fade.before * before + fade.now * now;
}
