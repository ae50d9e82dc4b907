// The world's light on a surface, hidden by others (and dimmed by media, as its volume was filled).
// Spherical harmonics against the cosine: Ramamoorthi and Hanrahan 2001, "An Efficient Representation for
// Irradiance Environment Maps".
#include "lib/lattice.glsl"
#include "lib/phase.glsl"
#include "shared/spherical_harmonics.h"
#include "scene/light_volumes_block.glsl"

layout(binding = WORLD_VOLUME_UNIT) uniform sampler3D u_world_on_surfaces_tx;

// [W/m^2]; n: the normal at p. open: what arrives where nothing hides or dims, which is taken outside.
vec3 world_irradiance(vec3 p, vec3 n, vec3 open)
{
    const float kFade = 0.15;  // of the volume's edge, towards its faces
    LatticeParams lattice = u_volumes.surfaces;
    vec3 q = (lattice.node_from_world * vec4(p, 1.0)).xyz / lattice.last;
    vec3 margin = min(q, 1.0 - q) / kFade;
    float inside = clamp(min(margin.x, min(margin.y, margin.z)), 0.0, 1.0);
    if (inside == 0.0)
        return open;
    p += n * (0.5 * lattice.spacing);  // off the nodes on the surface's other side
    const float kCosine[3] = float[3](kPi, 2.0 / 3.0 * kPi, 0.25 * kPi);
    vec4 sum = vec4(0.0);
    int i = 0;
    for (int l = 0; l < 3; ++l)
        for (; i < kHarmonics[l]; ++i) {
            vec4 light = textureLod(u_world_on_surfaces_tx, lattice_uvw(lattice, p, i), 0.0);
            sum += vec4(light.rgb * (kCosine[l] * spherical_harmonic(i, n)), light.a);
        }
    // Nodes that no light reaches have alpha 0 and are left out; if all are, it is dark.
    return mix(open, max(sum.rgb, vec3(0.0)) / max(sum.a, 1e-3), inside);
}
