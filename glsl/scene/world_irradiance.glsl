// The world's light on a surface, hidden by others (and dimmed by media, as its volume was filled).
// Spherical harmonics against the cosine: Ramamoorthi and Hanrahan 2001, "An Efficient Representation for
// Irradiance Environment Maps".
#include "lib/lattice.glsl"
#include "lib/phase.glsl"
#include "lib/walls.glsl"
#include "shared/spherical_harmonics.h"
#include "scene/light_volumes_block.glsl"

layout(binding = WORLD_ON_SURFACES_UNIT) uniform sampler3D u_world_on_surfaces_tx;
layout(binding = WALLS_UNIT) uniform sampler3D u_walls_tx;

// Whether a surface lies within a node on the way along n, by the axis that this goes along most.
bool is_walled_off(Walls walls, vec3 n)
{
    vec3 size = abs(n);
    vec3 wall = mix(walls.down, walls.up, step(0.0, n)) +
                mix(vec3(2.0), vec3(0.0), step(max(size.x, max(size.y, size.z)), size));
    return min(wall.x, min(wall.y, wall.z)) <= 1.0;
}

// Of the nodes around a place; alpha: what part of them does not lie inside of surfaces, which are left out.
vec4 sum_of_nodes(vec3 q, vec3 n)
{
    const float kCosine[3] = float[3](kPi, 2.0 / 3.0 * kPi, 0.25 * kPi);
    LatticeParams lattice = u_volumes.surfaces;
    vec3 uvw = (q + 0.5) * lattice.inverse_size;
    vec4 sum = vec4(0.0);
    int i = 0;
    for (int l = 0; l < 3; ++l)
        for (; i < kHarmonics[l]; ++i) {
            vec4 light = textureLod(u_world_on_surfaces_tx, in_layer(lattice, uvw, i), 0.0);
            sum += vec4(light.rgb * (kCosine[l] * spherical_harmonic(i, n)), light.a);
        }
    return sum;
}

vec3 irradiance_of_nodes(vec3 q, vec3 n)
{
    const float kFewest = 0.01;
    const vec3 kWays[7] = vec3[7](vec3(0.0), vec3(-1.0, 0.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, -1.0, 0.0),
                                  vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, -1.0), vec3(0.0, 0.0, 1.0));
    vec4 sum = vec4(0.0);
    // Where all are inside, as under a ball, what stands around the place counts, not what lies behind the surface. The
    // place itself is the loop's first turn: llvmpipe works out both sides of a branch for all pixels, while a loop
    // ends with the last pixel that goes on.
    for (int i = 0; i < 7; ++i) {
        if (dot(kWays[i], n) > -0.5)
            sum += sum_of_nodes(q + kWays[i], n);
        if (i == 0 && sum.a >= kFewest)
            break;
    }
    // If those are inside too, it is dark.
    return max(sum.rgb, vec3(0.0)) / max(sum.a, 1e-3);
}

// [W/m^2]; n: the normal at p. open: what arrives where nothing hides or dims, which is taken outside.
vec3 world_irradiance(vec3 p, vec3 n, vec3 open)
{
    const float kFade = 0.15;  // of the volume's edge, towards its faces
    LatticeParams lattice = u_volumes.surfaces;
    vec3 on = node_at(lattice, p);
    vec3 margin = min(on / lattice.last, 1.0 - on / lattice.last) / kFade;
    float inside = clamp(min(margin.x, min(margin.y, margin.z)), 0.0, 1.0);
    if (inside == 0.0)
        return open;
    vec3 way = node_way(lattice, n) * lattice.spacing;  // of the length of a node
    Walls walls;
    // Moved away from the nodes on the surface's other side.
    vec3 off = on_own_side(u_walls_tx, ivec3(0), lattice.last, on + 0.5 * way, walls);
    vec3 light = irradiance_of_nodes(off, n);
    if (!is_walled_off(walls, n)) {
        // From as far off the surface back to it.
        float height = clamp(dot(off - on, way), 0.0, 1.5);
        light = clamp(light + height * (light - irradiance_of_nodes(off + way, n)), 0.5 * light, 2.0 * light);
    }
    return mix(open, light, inside);
}
