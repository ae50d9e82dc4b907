// The lights' own light at each node of the field, as harmonics: what is scattered first. The mean over the node's
// cell, weighted by what there is to scatter it.
//   in   the volumes that dim lights; kTaken: light/field_taken.glsl
//   out  coefficients [W/m^2/sr]; alpha of the first: 1 if any light gets there
#include "lib/channels.glsl"
#include "lib/phase.glsl"
#include "light/field_listed.glsl"
#include "light/field_taken.glsl"
#include "shared/spherical_harmonics.h"
#include "light/dimmed_lights.glsl"

// Variant
const int kBands = 1;
const bool kTaken = false;      // each node sends out as much as it takes in
const bool kEnds = false;       // media end at faces of a box
const bool kLeavesOut = false;  // some points are no lights here

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(binding = 0) writeonly uniform image3D u_light_img;

const int kCount = kHarmonics[kBands - 1];
const int kSamples = 2;  // along each edge of a cell
const int kCellSamples = kSamples * kSamples * kSamples;
const int kPlaced = kLightPoints - kSunCount;

float g_own[max(kPlaced, 1)];  // of each light that has a place: own_light()
vec3 g_light[kCount];
float g_seen = 0.0;
vec3 g_part;  // half of a cell's part that a sample stands for, in nodes

// The same where a medium ends at a face, all at once: light that comes along it falls off from the face, and not on its
// own way.
vec3 dimmed_in_part(int i, vec3 p, LightSample light)
{
    vec3 all = vec3(0.0), across = vec3(0.0), mean = vec3(1.0);
    for (int axis = 0; axis < 3; ++axis) {
        vec3 edge = u_field.nodes.world_from_node[axis].xyz;
        edge *= min(g_part[axis], 0.5 * light.range / length(edge));
        vec3 low = dimming_at(i, p - edge, light), high = dimming_at(i, p + edge, light);
        vec3 change = abs(high - low);
        all += (low + high) / 6.0;
        across += 0.5 * change;
        mean *= slab_weight(change);
    }
    return exp(-max(all - across, vec3(0.0))) * mean;
}

// The mean of what gets through over the part of a cell that a sample stands for, so that a thick medium scatters all
// of the light that it takes in: exp(-tau), where tau grows evenly from the part's near end to its far one.
vec3 dimmed(int i, vec3 p, LightSample light)
{
    if (!kDims)
        return vec3(1.0);
    if (kEnds)
        return dimmed_in_part(i, p, light);
    vec3 way = light.wi * min(0.25 * u_field.nodes.spacing, 0.5 * light.range);
    vec3 near = dimming_at(i, p + way, light);
    vec3 far = dimming_at(i, p - way, light);
    return exp(-near) * slab_weight(max(far - near, vec3(0.0)));
}

// What of a light arrives at a sample. Nearer than `least` it is not told from others in the cell: what that gets of one
// within it is finite.
vec3 arriving_at(int i, vec3 p, LightSample light)
{
    float least = 0.25 * u_field.nodes.spacing;
    float near = min(light.range / least, 1.0);
    return light.irradiance * dimmed(i, p, light) * (near * near);
}

vec3 sample_place(int k, vec3 low, vec3 high)
{
    vec3 in_cell = (vec3(k & 1, k >> 1 & 1, k >> 2) + 0.5) / float(kSamples);
    return place_of(mix(low, high, in_cell));
}

// Of a light that stands in the node's own cell samples have too little, as 1/d^2 has no bound, and a thick cell takes
// nearly all of it in: this many times as much lies on the ways from the light to the cell's faces, of directions that
// are spread evenly.
float own_light(int i, vec3 low, vec3 high)
{
    vec3 position = u_lights.lights[i].position;
    vec3 at = node_at(u_field.nodes, position);
    bool is_own = all(greaterThanEqual(at, low)) && all(lessThan(at, high));
    int samples = is_own ? kCellSamples : 0;
    float sampled = 0.0, sigma_t = 0.0;
    for (int k = 0; k < samples; ++k) {
        vec3 p = sample_place(k, low, high);
        LightSample light = sample_of(position, vec3(1.0), flame_radius(i), p);
        sampled += mean(arriving_at(i, p, light)) / float(kCellSamples);
        if (kDims)
            sigma_t += mean(dimming_at(i, p, light)) / (light.range * float(kCellSamples));
    }
    const int kDirections = 32;
    float held = 0.0;  // of the light's intensity, over the cell [m sr]
    for (int k = 0; k < (is_own ? kDirections : 0); ++k) {
        float z = 1.0 - (2.0 * float(k) + 1.0) / float(kDirections), turn = 2.0 * kPi * fract(float(k) * 0.61803399);
        vec3 course = vec3(sqrt(1.0 - z * z) * vec2(cos(turn), sin(turn)), z);
        vec3 room = mix(at - low, high - at, step(0.0, course)) / max(abs(course), vec3(1e-9));
        float metres = min(room.x, min(room.y, room.z)) * u_field.nodes.spacing;
        held += 4.0 * kPi / float(kDirections) * metres * slab_weight(sigma_t * metres);
    }
    vec3 edges = (high - low) * u_field.nodes.spacing;
    return is_own ? held / (edges.x * edges.y * edges.z * max(sampled, 1e-20)) : 1.0;
}

void add_light(int i, vec3 p, float weight, LightSample light, float visibility)
{
    if (visibility == 0.0 || (kLeavesOut && i >= u_field.left_out.x && i < u_field.left_out.y))
        return;
    g_seen = 1.0;
    vec3 arriving = arriving_at(i, p, light) * (weight * visibility);
    if (!light.is_sun)
        arriving *= g_own[i - kSunCount];
    if (kLightFilters)
        arriving *= filter_in_medium(i, p);
    for (int j = 0; j < kCount; ++j)
        g_light[j] += arriving * spherical_harmonic(j, light.wi);
}

#include "written/field.glsl"

void main()
{
    ivec3 node = own_node();
    if (any(greaterThanEqual(node, node_count())))
        return;
    for (int i = 0; i < kCount; ++i)
        g_light[i] = vec3(0.0);
    float weights = 0.0;
    // Of a cell at the lattice's faces what lies within.
    vec3 low = max(vec3(node) - 0.5, vec3(0.0));
    vec3 high = min(vec3(node) + 0.5, u_field.nodes.last);
    g_part = (high - low) / float(2 * kSamples);
    HeldMedia held = held_media();
    for (int i = 0; i < kPlaced; ++i)
        g_own[i] = own_light(kSunCount + i, low, high);
    for (int k = 0; k < kCellSamples; ++k) {
        vec3 p = sample_place(k, low, high);
        vec3 sigma_s = sample_media(media_point(p, held)).sigma_s;
        float weight = dot(sigma_s, vec3(1.0)) + 1e-9;
        weights += weight;
        add_lights(p, weight);
    }
    vec3 part = vec3(1.0 / weights);
    if (kTaken)  // it is what the node's own cell takes in, which all that stands for the node sends out
        part *= taken_of_cell(node);
    float seen = g_seen;
    for (int i = 0; i < kCount; ++i)
        imageStore(u_light_img, node + layer_of(i), vec4(g_light[i] * part, i == 0 ? seen : 0.0));
}
