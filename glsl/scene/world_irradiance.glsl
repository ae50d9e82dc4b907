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

// How much a node counts on a surface: one behind it, or behind another that stands between, does not. Weights change
// with the place and never at once, which would show as an edge on the surface: as Majercik and others 2019, "Dynamic
// Diffuse Global Illumination with Ray-Traced Irradiance Fields", section 4, but by walls along the axes.
//   from     from the place to the node
//   heights  dot() with a way [nodes] is how far it leads away from the surface
float node_counts(Walls walls, vec3 from, vec3 heights)
{
    const float kHalfWay = 2.0;  // a node counts in full from half a node's height on
    const float kOther = 0.8;    // a wall that comes before this part of the way to the surface itself is another's
    const float kSharp = 64.0;   // a wall hides by parts within 1 / this of the way
    float height = dot(from, heights);
    vec3 falls = heights * sign(from);  // on the way back along each axis
    vec3 own = mix(vec3(1e4), kOther * height / max(falls, vec3(1e-4)), step(1e-4, falls));
    vec3 reach = max(min(abs(from), own), vec3(1e-4));
    vec3 wall = mix(walls.up, walls.down, step(0.0, from));
    vec3 seen = clamp(1.0 + kSharp * (wall / reach - 1.0), 0.0, 1.0);
    return clamp(kHalfWay * height, 0.0, 1.0) * seen.x * seen.y * seen.z;
}

// Whether nothing stands over a node before the next one, by the axis that n goes along most.
float is_open(Walls walls, vec3 n)
{
    vec3 size = abs(n);
    vec3 wall = mix(walls.down, walls.up, step(0.0, n)) +
                mix(vec3(2.0), vec3(0.0), step(max(size.x, max(size.y, size.z)), size));
    return step(1.0001, min(wall.x, min(wall.y, wall.z)));
}

// Of the nodes around a place; alpha: what part of them does not lie inside of surfaces, which are left out.
vec4 sum_of_nodes(vec3 at, vec3 n)
{
    const float kCosine[3] = float[3](kPi, 2.0 / 3.0 * kPi, 0.25 * kPi);
    LatticeParams lattice = u_volumes.surfaces;
    vec3 uvw = (at + 0.5) * lattice.inverse_size;
    vec4 sum = vec4(0.0);
    int i = 0;
    for (int l = 0; l < 3; ++l)
        for (; i < kHarmonics[l]; ++i) {
            vec4 light = textureLod(u_world_on_surfaces_tx, in_layer(lattice, uvw, i), 0.0);
            sum += vec4(light.rgb * (kCosine[l] * spherical_harmonic(i, n)), light.a);
        }
    return sum;
}

// Where the nodes around a place are looked up, so that those that don't count have no part.
struct Lookup {
    vec3 at;
    float weight;  // of those that count
    float open;    // part of their light that comes from the nodes over them, past surfaces and media
};

//   q  the place on the surface; it is looked up half a node above
Lookup lookup_above(vec3 q, vec3 way, vec3 n, vec3 heights)
{
    LatticeParams lattice = u_volumes.surfaces;
    vec3 at = q + 0.5 * way;
    vec3 base = clamp(floor(at), vec3(0.0), lattice.last - 1.0);
    vec3 t = clamp(at - base, 0.0, 1.0);
    Lookup sum = Lookup(vec3(0.0), 0.0, 0.0);
    for (int corner = 0; corner < 8; ++corner) {
        vec3 is_high = vec3(corner & 1, (corner >> 1) & 1, corner >> 2);
        vec3 near = mix(1.0 - t, t, is_high);
        vec3 node = base + is_high;
        Walls walls = walls_of(u_walls_tx, ivec3(node), int(lattice.last.z) + 1);
        float weight = near.x * near.y * near.z * node_counts(walls, node - q, heights);
        sum.at += weight * is_high;
        sum.open += weight * is_open(walls, n) * walls.through;
        sum.weight += weight;
    }
    float inverse = 1.0 / max(sum.weight, 1e-4);
    return Lookup(base + mix(t, sum.at * inverse, step(1e-4, sum.weight)), sum.weight, sum.open * inverse);
}

// [W/m^2]; n: the normal at p. open: what arrives where nothing hides or dims, which is taken outside.
vec3 world_irradiance(vec3 p, vec3 n, vec3 open)
{
    const float kFade = 0.15;    // of the volume's edge, towards its faces
    const float kFewest = 0.05;  // of the nodes
    const vec3 kWays[7] = vec3[7](vec3(0.0), vec3(-1.0, 0.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, -1.0, 0.0),
                                  vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, -1.0), vec3(0.0, 0.0, 1.0));
    LatticeParams lattice = u_volumes.surfaces;
    vec3 q = node_at(lattice, p);
    vec3 margin = min(q / lattice.last, 1.0 - q / lattice.last) / kFade;
    float inside = clamp(min(margin.x, min(margin.y, margin.z)), 0.0, 1.0);
    if (inside == 0.0)
        return open;
    vec3 way = node_way(lattice, n) * lattice.spacing;  // a node's length
    vec3 heights = (vec4(n, 0.0) * lattice.world_from_node).xyz / lattice.spacing;
    Lookup above = lookup_above(q, way, n, heights);
    // Where no node counts, as under a ball, what stands around the place does, and not what lies behind the surface.
    // The place itself is the loop's first turn: llvmpipe works out both sides of a branch for all pixels, while a loop
    // ends with the last pixel that goes on.
    vec4 low = vec4(0.0), around = vec4(0.0);
    float counts = 0.0;
    for (int i = 0; i < 7; ++i) {
        if (dot(kWays[i], n) > -0.5)
            around += sum_of_nodes(above.at + kWays[i], n);
        if (i > 0)
            continue;
        low = around;
        around = vec4(0.0);
        counts = clamp(min(above.weight, low.a) / kFewest, 0.0, 1.0);
        if (counts == 1.0)
            break;
    }
    vec4 high = sum_of_nodes(above.at + way, n);
    vec3 light = low.rgb / max(low.a, 1e-3);
    // From as far off the surface back to it, as far as light there tells of light here: a medium changes it on its way.
    float back = clamp(dot(above.at - q, heights), 0.0, 1.5) * above.open;
    back *= clamp(high.a / kFewest, 0.0, 1.0);
    // What grows upwards comes from something near, and falls off ever more slowly towards the surface: by the same part from
    // node to node.
    vec3 over = high.rgb / max(high.a, 1e-3);
    vec3 falls = pow(light / max(over, vec3(1e-20)), vec3(back));
    light =
        mix(min(light + back * (light - over), 2.0 * light), max(light * falls, 0.5 * light), greaterThan(over, light));
    // If those around are inside too, it is dark.
    light = mix(around.rgb / max(around.a, 1e-3), light, counts);
    return mix(open, max(light, vec3(0.0)), inside);
}
