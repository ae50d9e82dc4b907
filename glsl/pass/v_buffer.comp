// Froxels, before they are lit, where light is dimmed by what lies between them: the media into the V-buffer, one sample
// a froxel. Hillaire 2015, "Physically Based and Unified Volumetric Rendering in Frostbite", voxelisation of
// participating media.
//   out  sigma_s, sigma_t, emission   per slices.depth metres (shared/froxel_params.h)
//        phase  x: g times its weight, y: the weight, the sum of sigma_s
#include "scene/froxel_medium.glsl"
#include "scene/froxel_extinction.glsl"

layout(local_size_x = FROXEL_GROUP_X, local_size_y = FROXEL_GROUP_Y, local_size_z = FROXEL_GROUP_Z) in;
layout(binding = V_BUFFER_SIGMA_S_IMAGE) writeonly uniform image3D u_sigma_s_img;
layout(binding = V_BUFFER_SIGMA_T_IMAGE) writeonly uniform image3D u_sigma_t_img;
layout(binding = V_BUFFER_EMISSION_IMAGE) writeonly uniform image3D u_emission_img;
layout(binding = V_BUFFER_PHASE_IMAGE) writeonly uniform image3D u_phase_img;

void main()
{
    ivec3 froxel = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(froxel, froxel_count())))
        return;
    FroxelMedium medium = sampled_medium(froxel_sample(froxel));
    vec3 sigma_s = medium.sigma_s;
    imageStore(u_sigma_s_img, froxel, vec4(sigma_s, has_one_extinction() ? extinction_number(medium.sigma_t) : 0.0));
    if (!has_one_extinction())
        imageStore(u_sigma_t_img, froxel, vec4(medium.sigma_t, 0.0));
    if (kEmission)
        imageStore(u_emission_img, froxel, vec4(medium.emission, 0.0));
    if (kMixedG) {
        float weight = min(sigma_s.r + sigma_s.g + sigma_s.b, u_frame.radiance_limit);
        imageStore(u_phase_img, froxel, vec4(medium.g * weight, weight, 0.0, 0.0));
    }
}
