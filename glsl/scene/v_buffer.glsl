// What a froxel holds of media: sampled anew, or looked up in the V-buffer, which pass/v_buffer.comp fills where light
// is dimmed by it.
#include "scene/froxel_medium.glsl"
#include "scene/froxel_extinction.glsl"

// Variant: light is dimmed by the V-buffer, marched in the view's frustum, as in 2017: what lies outside of the view
// throws no shadow; else by the media themselves, and there is no V-buffer
const bool kGridShadows = false;

layout(binding = V_BUFFER_SIGMA_S_UNIT) uniform sampler3D u_sigma_s_tx;
layout(binding = V_BUFFER_SIGMA_T_UNIT) uniform sampler3D u_sigma_t_tx;
layout(binding = V_BUFFER_EMISSION_UNIT) uniform sampler3D u_emission_tx;
layout(binding = V_BUFFER_PHASE_UNIT) uniform sampler3D u_phase_tx;

FroxelMedium kept_medium(ivec3 froxel)
{
    vec4 sigma_s = texelFetch(u_sigma_s_tx, froxel, 0);
    FroxelMedium medium = FroxelMedium(sigma_s.rgb, vec3(0.0), vec3(0.0), u_media.media[0].g);
    if (has_one_extinction())
        medium.sigma_t = extinction_of_number(sigma_s.a);
    else
        medium.sigma_t = texelFetch(u_sigma_t_tx, froxel, 0).rgb;
    if (kEmission)
        medium.emission = texelFetch(u_emission_tx, froxel, 0).rgb;
    if (kMixedG) {
        vec2 phase = texelFetch(u_phase_tx, froxel, 0).xy;
        medium.g = phase.y > 0.0 ? phase.x / phase.y : 0.0;
    }
    return medium;
}

FroxelMedium medium_of(ivec3 froxel)
{
    if (kGridShadows)
        return kept_medium(froxel);
    return sampled_medium(froxel_sample(froxel));
}
