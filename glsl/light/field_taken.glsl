// How much of the media a node stands for on the ways through it. Between two nodes light meets the mean of their
// extinctions, half of which is the one's and half the other's: of what is taken in there, and of what is sent out.
#include "light/field.glsl"
#include "light/way_pairs.glsl"

layout(binding = FIELD_SIGMA_T_UNIT) uniform sampler3D u_taken_sigma_t_tx;

vec3 sigma_t_of(ivec3 node) { return texelFetch(u_taken_sigma_t_tx, clamp(node, ivec3(0), node_count() - 1), 0).rgb; }

// Along way k of the near ones and the one opposite [1/m]. own: the node's
vec3 taken_along(ivec3 node, int k, vec3 own)
{
    FieldWay way = u_field.ways[k];
    ivec3 step = from_axes(way.axis, ivec3(way.forward, floor(way.slope + 0.5)));
    return 0.25 * (sigma_t_of(node - step) + sigma_t_of(node + step)) + 0.5 * own;
}

// The mean of all near ways.
vec3 taken_at(ivec3 node, vec3 own)
{
    vec3 sum = vec3(0.0);
#define TAKE(k) sum += u_field.ways[k].solid_angle * taken_along(node, k, own);
    FOR_PAIRS_OF_26(TAKE, 0)
    return sum / (2.0 * 3.14159265);
}

// Sums over pairs of opposite near ways: of radiance by what it meets, of that, and of radiance alone.
struct TakenLight {
    vec3 taken, weights, light;
};

void add_taken(inout TakenLight sum, ivec3 node, int k, vec3 own, vec3 both)
{
    float solid_angle = u_field.ways[k].solid_angle;
    vec3 weight = solid_angle * taken_along(node, k, own);
    sum.taken += weight * both;
    sum.weights += 2.0 * weight;
    sum.light += solid_angle * both;
}

// By how much the mean radiance is more where each way counts by what it meets. The higher bands stay as they are: even
// light would not be even in them.
vec3 more_taken(TakenLight sum)
{
    const float kNone = 1e-20;  // where there is no medium
    const float kSphere = 4.0 * 3.14159265;
    return (sum.taken + kNone * sum.light) / (sum.weights + kNone * kSphere) - sum.light / kSphere;
}
