// What the media are at each node of a lattice: means over its cell.
//   out  sigma_t [1/m], and in alpha what surfaces cross of the near ways; unless kMarched, albedo, and in alpha g;
//        emission [W/m^2/sr per m]; sigma_t and albedo without the forward peak
#include "light/field.glsl"
#include "light/forward_peak.glsl"
#include "scene/light_volumes.glsl"

// Variant
const bool kGlows = false;     // emission is asked for
const bool kSurfaces = false;  // surfaces may stand between nodes
const bool kMarched = false;   // the extinction of the marched media is, and nothing else

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(binding = 0) writeonly uniform image3D u_sigma_t_img;
layout(binding = 1) writeonly uniform image3D u_albedo_img;
layout(binding = 2) writeonly uniform image3D u_emission_img;

void main()
{
    ivec3 node = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(node, node_count())))
        return;
    bool is_empty = any(lessThanEqual(vec3(node) + 0.5, u_field.media_low)) ||
                    any(greaterThanEqual(vec3(node) - 0.5, u_field.media_high));
    int n = is_empty ? 0 : u_volumes.samples;
    MediumSample sum = MediumSample(vec3(0.0), extinction_t(0.0), vec3(0.0), 0.0);
    vec2 phase = vec2(0.0);
    HeldMedia held = held_media();
    for (ivec3 place = ivec3(0); place.z < n; place = next_in_cell(place, n)) {
        vec3 in_cell = place_in_cell(place, n);
        // Of a cell at the lattice's faces what lies within.
        vec3 p = place_of(vec3(node) + in_cell);
        if (kMarched)
            sum.sigma_t += marched_extinction(p, held);
        else
            add_medium(sum, phase, sample_media(media_point(p, held)));
    }
    float share = 1.0 / float(max(n * n * n, 1));
    vec3 sigma_t = vec3(sum.sigma_t) * share;
    vec3 sigma_s = sum.sigma_s * share;
    // A place without a medium has the albedo that its neighbours have, as near as that is known.
    const float kLittle = 1e-9;
    vec3 albedo = (sigma_s + kLittle * u_field.albedo) / (max(sigma_t, sigma_s) + kLittle);
    float g = phase.y > 0.0 ? phase.x / phase.y : u_media.media[0].g;
    vec3 peak = forward_peak(albedo, g, u_field.straight_on);
    float crossed = kSurfaces ? crossed_near(node) : 0.0;
    imageStore(u_sigma_t_img, node, vec4(sigma_t * rest_of_extinction(albedo, peak), crossed));
    if (kMarched)
        return;
    imageStore(u_albedo_img, node, vec4(rest_of_albedo(albedo, peak), g));
    if (kGlows)
        imageStore(u_emission_img, node, vec4(sum.emission * share, 0.0));
}
