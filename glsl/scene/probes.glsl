// Light on glossy surfaces from all around: the world's, filtered by roughness.
#include "lib/probe_map.glsl"

layout(std140, binding = PROBES_BLOCK) uniform Probes { ProbesParams u_probes; };
layout(binding = WORLD_PROBE_UNIT) uniform sampler2DArray u_world_probe_tx;

// The world's radiance as a surface of GGX's alpha shows it about d, of any length.
vec3 world_reflection(vec3 d, float alpha)
{
    ProbeLevel level = probe_level(u_probes.world.last, alpha);
    vec2 uv = octahedral_uv(d);
    return mix(probe_map_at(u_world_probe_tx, u_probes.world.maps[level.lower], 0, uv).rgb,
               probe_map_at(u_world_probe_tx, u_probes.world.maps[level.lower + 1], 0, uv).rgb, level.part);
}
