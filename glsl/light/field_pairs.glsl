// Light of the ways of a batch against harmonics, for two opposite ways at a time: those of even bands are the same for
// both, those of odd bands differ in sign alone, which is half of the work.
#include "light/field_listed.glsl"
#include "light/way_pairs.glsl"
#include "shared/spherical_harmonics.h"

const int kBands = 1;  // variant

layout(binding = FIELD_WAYS_UNIT) uniform usampler3D u_ways_tx;

const float kMean0 = 0.28209479;  // the first harmonic: a coefficient times it is the mean over all directions

const int kCount = kHarmonics[kBands - 1];
vec3 g_light[kCount];

bool is_even(int i) { return i == 0 || (i >= kHarmonics[1] && i < kHarmonics[2]); }

float harmonic_of(int k, int i) { return spherical_harmonic(i, u_field.ways[k].wi); }

// 1, which no compiler can tell. A pass that sums over harmonics both ways would keep them from one sum to the other,
// sixteen of each of 13 pairs, in registers that it has not.
float opaque_one() { return u_field.slots < 0 ? 0.0 : 1.0; }

// As light goes from order to order, and as the world's and the surfaces' comes.
vec3 light_of_way(ivec3 node, int k) { return unpack_light(texelFetch(u_ways_tx, node + way_of(k), 0).rg); }
vec4 radiance_of_way(ivec3 node, int k) { return unpack_way(texelFetch(u_ways_tx, node + way_of(k), 0).rg); }

// Adds to coefficients what ways k and k + 1 bring.
void add_pair(inout vec3 light[kCount], int k, vec3 one, vec3 other)
{
    vec3 even = u_field.ways[k].solid_angle * (one + other);
    vec3 odd = u_field.ways[k].solid_angle * (one - other);
    for (int i = 0; i < kCount; ++i)
        light[i] += (is_even(i) ? even : odd) * harmonic_of(k, i);
}

// Of light that has these coefficients, what goes along way k is the sum of both, and along k + 1 their difference.
void sum_pair(int k, out vec3 even, out vec3 odd)
{
    even = vec3(0.0);
    odd = vec3(0.0);
    vec3 wi = u_field.ways[k].wi * opaque_one();
    for (int i = 0; i < kCount; ++i) {
        if (is_even(i))
            even += g_light[i] * spherical_harmonic(i, wi);
        else
            odd += g_light[i] * spherical_harmonic(i, wi);
    }
}
