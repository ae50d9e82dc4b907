// The world's light on a surface, hidden by others (and dimmed by media, as its volume was filled).
// Spherical harmonics against the cosine: Ramamoorthi and Hanrahan 2001, "An Efficient Representation for
// Irradiance Environment Maps".
#include "lib/lattice.glsl"
#include "lib/phase.glsl"
#include "lib/sights.glsl"
#include "shared/spherical_harmonics.h"
#include "scene/light_volumes_block.glsl"

#include "scene/fire_irradiance.glsl"

// Variant
const bool kOneBox = false;     // a box is all that stands in the volume: nothing hides a node before one of its sides
const bool kLitBeyond = false;  // beyond the volume places have light of the media too: nodes at its rim have it
const bool kAllBeyond = false;  // all places are there

layout(binding = WORLD_ON_SURFACES_UNIT) uniform sampler3D u_world_on_surfaces_tx;
layout(binding = WALLS_UNIT) uniform usampler3D u_sights_tx;

// What stands before a node along the ways of its octant, the surface itself left out: inverse distances, 0 where nothing
// is met. A plane's grow evenly from way to way.
struct Hidden {
    vec3 axes, faces;
    float middle;
};

vec3 inverse_distance(vec3 steps)
{
    return mix(1.0 / max(steps, vec3(1e-3)), vec3(0.0), greaterThan(steps, vec3(1.001)));
}

// Of what lies behind the surface itself along a way, that is met there at `own`: what is met along the ways beside it, if
// it goes on as far.
float behind_own(float own, vec3 beside)
{
    vec3 goes_on = beside * clamp(6.0 - 5.0 * beside / max(own, 1e-3), 0.0, 1.0);
    return max(goes_on.x, max(goes_on.y, goes_on.z));
}

// falls: of the surface's plane, inverse distances along the axes
Hidden hidden_by_others(Sight sight, vec3 falls)
{
    const float kOthers = 4.0;  // what is met by 1 / this of the way before the surface itself is all another's
    vec3 own_faces = falls.yzx + falls.zxy;
    float own_middle = falls.x + own_faces.x;
    Hidden hidden =
        Hidden(inverse_distance(sight.axes), inverse_distance(sight.faces), inverse_distance(vec3(sight.middle)).x);
    hidden.axes *= clamp(kOthers * (hidden.axes / max(falls, vec3(1e-3)) - 1.0), 0.0, 1.0);
    vec3 axes = hidden.axes, faces = hidden.faces;
    vec3 behind = vec3(behind_own(faces.x, axes.yzz), behind_own(faces.y, axes.zxx), behind_own(faces.z, axes.xyy));
    hidden.faces = mix(behind, faces, clamp(kOthers * (faces / max(own_faces, vec3(1e-3)) - 1.0), 0.0, 1.0));
    float behind_middle = max(behind_own(hidden.middle, axes), behind_own(hidden.middle, hidden.faces));
    hidden.middle =
        mix(behind_middle, hidden.middle, clamp(kOthers * (hidden.middle / max(own_middle, 1e-3) - 1.0), 0.0, 1.0));
    return hidden;
}

// How much a node counts on a surface, 0 to 1.
struct Counts {
    float above;   // not if it lies behind the surface
    float weight;  // nor inside of another; ever less, the more of another stands between
    float seen;    // nor if another hides it, by far
    float clear;   // nor if another stands between along an axis, at once
};

// Weights change with the place and never at once, which would show as an edge on the
// surface: as Majercik and others 2019, "Dynamic Diffuse Global Illumination with Ray-Traced Irradiance Fields", section
// 4, but by what the node meets along 26 ways.
//   from     from the place to the node
//   heights  dot() with a way [nodes] is how far it leads away from the surface
Counts node_counts(Sight sight, vec3 from, vec3 heights)
{
    const float kHalfWay = 2.0;  // a node counts in full from half a node's height on
    const float kOther = 0.8;    // a wall that comes before this part of the way to the surface itself is another's
    const float kSharp = 64.0;   // a wall along an axis hides by parts within 1 / this of the way
    float height = dot(from, heights);
    float above = clamp(kHalfWay * height, 0.0, 1.0);
    float outside = above * sight.outside;
    if (kOneBox)
        return Counts(above, outside, outside, outside);
    Hidden by = hidden_by_others(sight, heights * sign(from) / max(kOther * height, 1e-3));
    // The way to the place is made up of three ways that are next to each other: one along an axis, one between two.
    vec3 d = abs(from);
    vec3 lower = min(d.yzx, d.zxy);
    float least = min(d.x, lower.x);
    float hidden = dot(max(d - max(d.yzx, d.zxy), vec3(0.0)), by.axes) + dot(max(lower - d, vec3(0.0)), by.faces) +
                   least * by.middle;
    // Where walls meet, the plane between what is met on both would cut the corner off: what stands along the axes only.
    vec3 along = d * by.axes, across = lower * by.faces;
    float by_axes = max(along.x, max(along.y, along.z));
    hidden = min(hidden, max(max(by_axes, least * by.middle), max(across.x, max(across.y, across.z))));
    return Counts(above, outside * exp2(-3.0 * min(hidden * hidden * hidden, 20.0)),
                  outside * clamp(3.0 - 2.0 * hidden, 0.0, 1.0),
                  outside * clamp(1.0 + kSharp * (1.0 - by_axes), 0.0, 1.0));
}

// Whether nothing stands over a node before the next one, by the axis that n goes along most.
float is_open(Sight sight, vec3 from, vec3 n)
{
    if (kOneBox)
        return 1.0;
    vec3 size = abs(n);
    vec3 open = mix(step(1.001, sight.axes), sight.behind, step(0.0, from * n));
    return dot(open, step(max(size.yzx, size.zxy), size));
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
    float seen;   // part of those above the surface that are
    float clear;  // of all
    float open;   // part of their light that comes from the nodes over them, past surfaces and media
};

//   q  the place on the surface; it is looked up half a node above
Lookup lookup_above(vec3 q, vec3 way, vec3 n, vec3 heights)
{
    const float kNone = 1e-30;
    LatticeParams lattice = u_volumes.surfaces;
    int nodes_z = int(lattice.last.z) + 1;
    vec3 at = q + 0.5 * way;
    vec3 base = clamp(floor(at), vec3(0.0), lattice.last - 1.0);
    vec3 t = clamp(at - base, 0.0, 1.0);
    Lookup sum = Lookup(vec3(0.0), 0.0, 0.0, 0.0);
    float weight = 0.0, above = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
        vec3 is_high = vec3(corner & 1, (corner >> 1) & 1, corner >> 2);
        vec3 near = mix(1.0 - t, t, is_high);
        float part = near.x * near.y * near.z;
        vec3 node = base + is_high;
        vec3 from = node - q;
        Sight sight = sight_of(u_sights_tx, ivec3(node), nodes_z, -from);
        Counts counts = node_counts(sight, from, heights);
        sum.at += part * counts.weight * is_high;
        sum.open += part * counts.weight * is_open(sight, from, n) * sight.through;
        sum.seen += part * counts.seen;
        sum.clear += part * counts.clear;
        weight += part * counts.weight;
        above += part * counts.above;
    }
    float inverse = 1.0 / max(weight, kNone);
    return Lookup(base + mix(t, sum.at * inverse, step(kNone, weight)), sum.seen / max(above, 1e-3), sum.clear,
                  sum.open * inverse);
}

const float kFewest = 0.05;  // of the nodes

// Beyond the volume what arrives for the media's sake, beside what does where nothing hides or dims, falls off as a ball
// of their size fills ever less of what is seen: from where the way to its middle comes into the volume.
//   q  the place, in nodes
vec3 beyond_volume(vec3 q, vec3 n, vec3 open)
{
    if (!kLitBeyond)
        return open;
    LatticeParams lattice = u_volumes.surfaces;
    vec3 middle = node_at(lattice, u_volumes.media_middle);
    vec3 way = q - middle;
    vec3 room =
        mix(middle - SURFACES_RIM * lattice.last, (1.0 - SURFACES_RIM) * lattice.last - middle, step(0.0, way)) /
        max(abs(way), vec3(1e-6));
    float nearer = clamp(min(room.x, min(room.y, room.z)), 0.0, 1.0);
    vec4 light = sum_of_nodes(middle + nearer * way, n);
    vec3 to_middle = u_volumes.media_middle - (lattice.world_from_node * vec4(q, 1.0)).xyz;
    float range = max(length(to_middle), 1e-20), along = dot(to_middle, n) / range;
    float sine = min(u_volumes.media_radius / range, 1.0), nearer_sine = min(sine / max(nearer, 1e-6), 1.0);
    float falls = nearer * nearer * clamp(light.a / kFewest, 0.0, 1.0);
    falls *= cosine_of_cone(along, sine) / max(cosine_of_cone(along, nearer_sine), 1e-6);
    return max(open + falls * (light.rgb / max(light.a, 1e-3) - open), vec3(0.0));
}

// [W/m^2]; n: the normal at p. open: what arrives where nothing hides or dims.
vec3 world_irradiance(vec3 p, vec3 n, vec3 open)
{
    const float kFewSeen = 0.25;     // of those above the surface
    const float kHardlySeen = 5e-3;  // and so few that they tell nothing
    const float kFewestClear = 0.01;
    const float kMostOff = 1.6;  // times what is seen, that what lies around is believed to have, or part of it
    const vec3 kWays[7] = vec3[7](vec3(0.0), vec3(-1.0, 0.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, -1.0, 0.0),
                                  vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, -1.0), vec3(0.0, 0.0, 1.0));
    LatticeParams lattice = u_volumes.surfaces;
    vec3 q = node_at(lattice, p);
    if (kAllBeyond)
        return beyond_volume(q, n, open);
    vec3 margin = min(q / lattice.last, 1.0 - q / lattice.last) / SURFACES_RIM;
    float inside = clamp(min(margin.x, min(margin.y, margin.z)), 0.0, 1.0);
    vec3 way = node_way(lattice, n) * lattice.spacing;  // a node's length
    if (inside == 0.0)
        return beyond_volume(q, n, open) + fire_irradiance(p, n, clamp(q + way, vec3(0.0), lattice.last), inside);
    vec3 heights = (vec4(n, 0.0) * lattice.world_from_node).xyz / lattice.spacing;
    Lookup above = lookup_above(q, way, n, heights);
    // Where few nodes count, as under a ball, what stands around the place does too, and not what lies behind the surface.
    // The nodes above are the loop's first turn: llvmpipe works out both sides of a branch for all pixels, while a loop
    // ends with the last pixel that goes on.
    vec4 low = vec4(0.0), around = vec4(0.0);
    float few = 0.0, hardly = 0.0, clear = 0.0;
    for (int i = 0; i < 7; ++i) {
        if (dot(kWays[i], n) > -0.5)
            around += sum_of_nodes(i == 0 ? above.at : q + 0.5 * way + kWays[i], n);
        if (i > 0)
            continue;
        low = around;
        around = vec4(0.0);
        few = clamp(min(above.seen / kFewSeen, low.a / kFewest), 0.0, 1.0);
        hardly = clamp(above.seen / kHardlySeen, 0.0, 1.0);
        clear = clamp(above.clear / kFewestClear, 0.0, 1.0);
        if (min(few, clear) == 1.0)
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
    // The nodes of the next cell are among those around, so that light does not change at once where it begins. Behind a
    // wall it may be far brighter there: only so much of that is believed.
    vec3 beside = around.rgb / max(around.a, 1e-3);
    light = mix(clamp(beside, light / kMostOff, light * kMostOff), light, few);
    // If those around are inside too, it is dark.
    light = mix(beside, light, hardly);
    // Past a corner a node may be in the dark, as under a roof beside a gap in it, where the place itself is not.
    light = mix(max(light, beside), light, clear);
    light = max(light, vec3(0.0));
    if (inside < 1.0)
        light = mix(beyond_volume(q, n, open), light, inside);
    return light + fire_irradiance(p, n, above.at, inside);
}
