// The lights' own light at each node of the field, as harmonics: what is scattered first. The mean over the node's
// cell, weighted by what there is to scatter it.
//   in   the volumes that dim lights; kTaken: light/field_taken.glsl
//   out  coefficients [W/m^2/sr]; alpha of the first: 1 if any light gets there
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

void add_light(int i, vec3 p, float weight, LightSample light, float visibility)
{
    if (visibility == 0.0 || (kLeavesOut && i >= u_field.left_out.x && i < u_field.left_out.y))
        return;
    g_seen = 1.0;
    // Nearer than this a light is not told from others in the cell. What the cell gets of one within it is finite.
    float least = 0.25 * u_field.nodes.spacing;
    float near = light.range < least ? light.range / least : 1.0;
    vec3 arriving = light.irradiance * dimmed(i, p, light) * (weight * visibility * near * near);
    if (kLightFilters)
        arriving *= filter_in_medium(i, p);
    for (int j = 0; j < kCount; ++j)
        g_light[j] += arriving * spherical_harmonic(j, light.wi);
}

#include "written/field.glsl"

void main()
{
    const int kSamples = 2;  // along each edge of a cell
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
    for (int k = 0; k < kSamples * kSamples * kSamples; ++k) {
        vec3 in_cell = (vec3(k & 1, k >> 1 & 1, k >> 2) + 0.5) / float(kSamples);
        vec3 p = place_of(mix(low, high, in_cell));
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
