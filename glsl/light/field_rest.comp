// How much of each order that was kept makes the guess at what all of them would come to: the mean, of weights whose sum
// is 1, that one more order would change least. Reduced rank extrapolation: Smith, Ford and Sidi 1987, "Extrapolation
// methods for vector sequences", sec. 2; for a linear iteration it is GMRES with as many vectors (Saad and Schultz 1986).
//   in   what each order scatters and what the next changes; sigma_t and albedo, which weigh the nodes
//   out  of each slice of nodes along z the sum of the products of two changes, a row a pair, and in the last row of
//        the square of what the last order scatters
//   kFinish: from those the weights, a texel an order; then how much an order would change of the guess, of all
#include "light/field.glsl"

// Variant
const bool kFinish = false;  // sums up the slices

layout(local_size_x = 64) in;
layout(binding = 0) writeonly uniform image3D u_sums_img;
layout(binding = FIELD_LIGHT_UNIT) uniform sampler3D u_slices_tx;
layout(binding = FIELD_SOURCE_UNIT) uniform sampler3D u_kept_tx;
layout(binding = FIELD_SIGMA_T_UNIT) uniform sampler3D u_sigma_t_tx;
layout(binding = FIELD_ALBEDO_UNIT) uniform sampler3D u_albedo_tx;

const int kMost = FIELD_KEPT_ORDERS;

shared vec3 g_sums[64];

// The pairs (0, 0), (1, 0), (1, 1), (2, 0) ...
int pair_of(int i, int j) { return i * (i + 1) / 2 + j; }

vec3 sum_of(int pair)
{
    vec3 sum = vec3(0.0);
    for (int slice = 0; slice < node_count().z; ++slice)
        sum += texelFetch(u_slices_tx, ivec3(slice, pair, 0), 0).rgb;
    return sum;
}

void finish(int n)
{
    // As much of what is scattered as rounding may change from order to order: orders that differ by less tell nothing.
    const float kRounding = 3e-4, kLeast = 1e-6;
    vec3 products[kMost * (kMost + 1) / 2];
    for (int pair = 0; pair < pair_of(n, 0); ++pair)
        products[pair] = sum_of(pair);
    vec3 all = max(sum_of(pair_of(n, 0)), vec3(1e-30));
    vec3 rounding = kRounding * kRounding * all;
    vec3 size[kMost];
    for (int i = 0; i < n; ++i)
        size[i] = sqrt(products[pair_of(i, i)] + rounding);
    // Cholesky's factors of the products as they are between changes of size 1, and the equations solved.
    vec3 factor[kMost * (kMost + 1) / 2];
    vec3 weights[kMost];
    for (int i = 0; i < n; ++i)
        for (int j = 0; j <= i; ++j) {
            vec3 sum = i == j ? vec3(1.0 + kLeast) : products[pair_of(i, j)] / (size[i] * size[j]);
            for (int k = 0; k < j; ++k)
                sum -= factor[pair_of(i, k)] * factor[pair_of(j, k)];
            factor[pair_of(i, j)] = i == j ? sqrt(max(sum, vec3(kLeast))) : sum / factor[pair_of(j, j)];
        }
    for (int i = 0; i < n; ++i) {
        weights[i] = 1.0 / size[i];
        for (int k = 0; k < i; ++k)
            weights[i] -= factor[pair_of(i, k)] * weights[k];
        weights[i] /= factor[pair_of(i, i)];
    }
    vec3 sum = vec3(0.0);
    for (int i = n - 1; i >= 0; --i) {
        for (int k = i + 1; k < n; ++k)
            weights[i] -= factor[pair_of(k, i)] * weights[k];
        weights[i] /= factor[pair_of(i, i)];
    }
    for (int i = 0; i < n; ++i) {
        weights[i] /= size[i];
        sum += weights[i];
    }
    vec3 left = vec3(0.0);
    for (int i = 0; i < n; ++i) {
        weights[i] /= sum;
        imageStore(u_sums_img, ivec3(i, 0, 0), vec4(weights[i], 0.0));
        for (int j = 0; j <= i; ++j)
            left += (i == j ? 1.0 : 2.0) * weights[i] * weights[j] * products[pair_of(i, j)];
    }
    imageStore(u_sums_img, ivec3(kMost, 0, 0), vec4(sqrt(max(left, vec3(0.0)) / all), 0.0));
}

void main()
{
    int own = int(gl_LocalInvocationIndex);
    int n = u_field.slots;
    if (kFinish) {
        if (own == 0)
            finish(n);
        return;
    }
    int slice = int(gl_WorkGroupID.z), pair = int(gl_WorkGroupID.y);
    int i = 0;
    while (pair_of(i + 1, 0) <= pair)
        ++i;
    int j = pair - pair_of(i, 0);
    ivec3 one = i < n ? layer_of(2 * i + 1) : layer_of(2 * n - 2);
    ivec3 other = i < n ? layer_of(2 * j + 1) : one;
    ivec2 size = node_count().xy;
    vec3 sum = vec3(0.0);
    for (int at = own; at < size.x * size.y; at += 64) {
        ivec3 node = ivec3(at % size.x, at / size.x, slice);
        vec3 weight = texelFetch(u_sigma_t_tx, node, 0).rgb * texelFetch(u_albedo_tx, node, 0).rgb;
        sum += weight * texelFetch(u_kept_tx, node + one, 0).rgb * texelFetch(u_kept_tx, node + other, 0).rgb;
    }
    g_sums[own] = sum;
    barrier();
    if (own > 0)
        return;
    for (int k = 1; k < 64; ++k)
        sum += g_sums[k];
    imageStore(u_sums_img, ivec3(slice, pair, 0), vec4(sum, 0.0));
}
