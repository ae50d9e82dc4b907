// What a medium scatters of the world's light towards the eye, at each node: the phase function's bands
// against the light's, Henyey-Greenstein's l-th times g^l (Sloan 2008; the expansion of Henyey and
// Greenstein 1941). The eye is one point, so this depends on the node alone, and the march fetches once.
//   in   coefficients of the world's light; kFades: and of that before
//   out  the fourth root of the radiance per metre and unit of sigma_s; alpha as it was; kMixedG: the radiance
//        itself, a layer a band, g^l left out; kAmidVolume: nothing, and alpha 0, where another volume tells it
#include "shared/spherical_harmonics.h"
#include "light/fade.glsl"
#include "scene/light_volumes.glsl"

// Variant
const int kBands = 1;  // of the coefficients, to 4
const bool kFades = false;

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(binding = WORLD_COEFFICIENTS_UNIT) uniform sampler3D u_coefficients_tx;
layout(binding = 0) writeonly uniform image3D u_view_img;

void main()
{
    ivec3 node = ivec3(gl_GlobalInvocationID);
    LatticeParams lattice = u_volumes.world;
    if (any(greaterThan(node, ivec3(lattice.last))))
        return;
    ivec3 layer = ivec3(0, 0, int(lattice.last.z) + 1);
    vec3 p = node_position(lattice, node);
    // Along the eye's ray: g > 0 sends on what comes from behind the node.
    vec3 d = u_volumes.orthographic > 0.0 ? u_volumes.view_axis : p / max(length(p), 1e-20);
    vec4 band[4] = vec4[4](vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0));
    Fade fade;
    if (kFades)
        fade = fade_at(node);
    int i = 0;
    for (int l = 0; l < kBands; ++l)
        for (; i < kHarmonics[l]; ++i) {
            vec4 light = texelFetch(u_coefficients_tx, node + layer * i, 0);
            if (kFades)
                light.rgb = next_faded(fade, light.rgb);
            band[l] += light * spherical_harmonic(i, d);
        }
    band[0].a = texelFetch(u_coefficients_tx, node, 0).a;
    if (kAmidVolume && amid_share(node_at(u_volumes.amid, p)) > 0.0)
        band[0] = band[1] = band[2] = band[3] = vec4(0.0);
    for (int l = 0; kMixedG && l < kBands; ++l)
        imageStore(u_view_img, node + layer * l, band[l]);
    if (kMixedG)
        return;
    float g = u_media.media[0].g;
    vec4 light = band[0] + g * (band[1] + g * (band[2] + g * band[3]));
    // What bands 0 to 3 leave of a sharp edge may dip below 0.
    imageStore(u_view_img, node, vec4(root_of_light(max(light.rgb, vec3(0.0))), light.a));
}
