// The V-buffer: what each froxel holds of media, per slices.depth metres (shared/froxel_params.h).
#include "scene/froxels.glsl"
#include "scene/froxel_extinction.glsl"
#include "scene/media.glsl"

layout(binding = V_BUFFER_SIGMA_S_UNIT) uniform sampler3D u_sigma_s_tx;
layout(binding = V_BUFFER_SIGMA_T_UNIT) uniform sampler3D u_sigma_t_tx;
layout(binding = V_BUFFER_EMISSION_UNIT) uniform sampler3D u_emission_tx;
layout(binding = V_BUFFER_PHASE_UNIT) uniform sampler3D u_phase_tx;

vec4 kept_extinction(ivec3 froxel)
{
    if (has_one_extinction())
        return extinction_of_number(texelFetch(u_sigma_s_tx, froxel, 0));
    return texelFetch(u_sigma_t_tx, froxel, 0);
}

// What a froxel holds of media.
struct Medium {
    vec3 sigma_s, emission;
    float g;
};

Medium medium_of(ivec3 froxel)
{
    Medium medium = Medium(texelFetch(u_sigma_s_tx, froxel, 0).rgb, vec3(0.0), u_media.media[0].g);
    if (kEmission)
        medium.emission = texelFetch(u_emission_tx, froxel, 0).rgb;
    if (kMixedG) {
        vec2 phase = texelFetch(u_phase_tx, froxel, 0).xy;
        medium.g = phase.y > 0.0 ? phase.x / phase.y : 0.0;
    }
    return medium;
}
