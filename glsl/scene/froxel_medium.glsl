// What a froxel holds of media, per slices.depth metres (shared/froxel_params.h).
#include "scene/froxel_sample.glsl"

struct FroxelMedium {
    vec3 sigma_s, sigma_t, emission;
    float g;
};

vec3 held(vec3 value) { return min(value * u_froxels.slices.depth, vec3(u_frame.radiance_limit)); }

FroxelMedium sampled_medium(FroxelSample at)
{
    MediumSample medium = MediumSample(vec3(0.0), extinction_t(0.0), vec3(0.0), 0.0);
    if (at.share > 0.0)
        medium = sample_media(at.p);
    return FroxelMedium(held(medium.sigma_s * at.share), held(vec3(medium.sigma_t) * at.share),
                        held(medium.emission * at.share), medium.g);
}
