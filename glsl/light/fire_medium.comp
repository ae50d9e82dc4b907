// What the media are at the nodes of a lattice: means over its cells.
//   out  extinction [1/m], one number if it is of one colour; kGlows: emission [W/m^2/sr per m]
#include "lib/channels.glsl"
#include "scene/light_volumes.glsl"

// Variant
const bool kGlows = false;     // over what glows, and how much; else over all media
const bool kOneColor = false;  // its brightest channel tells what dims

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(binding = 0) writeonly uniform image3D u_sigma_t_img;
layout(binding = 1) writeonly uniform image3D u_emission_img;

void main()
{
    // Media may end at the lattice's faces, and on them it would be a matter of rounding whether there is any.
    const float kRim = 1e-3;
    LatticeParams lattice = kGlows ? u_volumes.fire.flame : u_volumes.fire.media;
    ivec3 node = ivec3(gl_GlobalInvocationID);
    if (any(greaterThan(node, ivec3(lattice.last))))
        return;
    int n = u_volumes.samples;
    HeldMedia held = held_media();
    vec3 sigma_t = vec3(0.0), emission = vec3(0.0);
    for (ivec3 place = ivec3(0); place.z < n; place = next_in_cell(place, n)) {
        vec3 q = clamp(vec3(node) + place_in_cell(place, n), vec3(kRim), lattice.last - kRim);
        MediumSample medium = sample_media(media_point((lattice.world_from_node * vec4(q, 1.0)).xyz, held));
        sigma_t += vec3(medium.sigma_t);
        emission += medium.emission;
    }
    float share = 1.0 / float(n * n * n);
    if (kOneColor)
        sigma_t = vec3(most(sigma_t));
    imageStore(u_sigma_t_img, node, vec4(sigma_t * share, 0.0));
    if (kGlows)
        imageStore(u_emission_img, node, vec4(emission * share, 0.0));
}
