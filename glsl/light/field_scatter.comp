// What the media scatter at each node into each way: the phase function's bands against the light's, Henyey-Greenstein's
// l-th times g^l. Light is that which comes first, and what the order before brought along all ways.
// Where the rest is to be guessed from what there is, what is scattered alike in all directions is kept with what each
// order changes of it, and at the end the mean of the orders is taken that would change least: see field_rest.comp.
//   in   coefficients of the light that comes first; radiance of each way; albedo and g; kTaken: light/field_taken.glsl
//   out  radiance that a thick medium of this light would have, of each way [W/m^2/sr]; the light's mean radiance
#include "light/field_pairs.glsl"
#include "light/field_taken.glsl"
#include "light/forward_peak.glsl"

// Variant
const bool kFirst = false;   // no way has brought anything yet
const bool kMean = false;    // what is scattered is not asked for
const bool kKeeps = false;   // orders are kept
const bool kOwn = false;     // nothing is scattered: what a guess has is kept
const bool kBefore = false;  // light of an earlier filling is added, from its own lattice
const bool kTail = false;    // in place of the last order the guess is taken
const bool kTaken = false;   // each way counts by what it meets
const bool kAhead = false;   // what a node keeps of its own light is taken as if it had gone on for ever

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(binding = 0) writeonly uniform uimage3D u_source_img;
layout(binding = 1) writeonly uniform uimage3D u_mean_img;
layout(rgba32f, binding = 2) uniform image3D u_kept_img;  // of each order, what is scattered and what the next changes
layout(binding = FIELD_LIGHT_UNIT) uniform sampler3D u_first_tx;
layout(binding = FIELD_ALBEDO_UNIT) uniform sampler3D u_albedo_tx;
layout(binding = FIELD_SUMS_UNIT) uniform sampler3D u_weights_tx;
layout(binding = FIELD_EMISSION_UNIT) uniform sampler3D u_own_tx;  // nothing is emitted here
layout(binding = FIELD_ORDER_UNIT) uniform sampler3D u_before_tx;

vec3 g_stored = vec3(0.0);  // the mean of what is stored, as it is rounded

vec3 g_more = vec3(0.0);  // of the mean radiance, as some ways count more than others

void gather_pair(ivec3 node, int k)
{
    vec3 one = light_of_way(node, k), other = light_of_way(node, k + 1);
    add_pair(g_light, k, one, other);
    if (kTaken)
        g_more += taken_more(node, k) * (one + other);
}

void store(ivec3 at, int k, vec3 source)
{
    uvec4 bits = pack_light(source, at);
    imageStore(u_source_img, at, bits);
    if (kKeeps)
        g_stored += u_field.ways[k].solid_angle * unpack_light(bits.rg);
}

void scatter_pair(ivec3 node, int k, vec3 more)
{
    vec3 even, odd;
    sum_pair(k, even, odd);
    even += more;
    store(node + way_of(k), k, even + odd);
    store(node + way_of(k + 1), k + 1, even - odd);
}

#define GATHER(k) gather_pair(node, k);
#define SCATTER(k) scatter_pair(node, k, more);

// What is scattered alike in all directions, for that which a node gets: as the order before is changed by it.
vec3 next_order(ivec3 node, vec3 got, vec3 albedo)
{
    ivec3 at = node + layer_of(2 * u_field.slot);
    vec3 before = imageLoad(u_kept_img, at).rgb;
    vec3 change = got - before;
    // Olson, Auer and Buchler 1986, "A rapidly convergent iterative solution of the non-LTE line radiation transfer
    // problem", sec. 2: Jacobi's iteration, with the part of its own light that each node gets back.
    if (kAhead)
        change /= 1.0 - albedo * texelFetch(u_own_tx, node, 0).rgb;
    imageStore(u_kept_img, at + layer_of(1), vec4(change, 0.0));
    return before + change;
}

vec3 guess(ivec3 node)
{
    vec3 sum = vec3(0.0);
    for (int i = 0; i < u_field.slots; ++i)
        sum +=
            texelFetch(u_weights_tx, ivec3(i, 0, 0), 0).rgb *
            (imageLoad(u_kept_img, node + layer_of(2 * i)).rgb + imageLoad(u_kept_img, node + layer_of(2 * i + 1)).rgb);
    return max(sum, vec3(0.0));
}

// Light that arrived at a node when another lattice was filled; alpha of the first: 0 in nodes inside of surfaces, which
// are left out of the mean of eight. Those that no medium was near to are dark.
void add_before(ivec3 node)
{
    vec3 uvw = first_layer_at(u_field.other, node_position(u_field.nodes, node));
    float seen = max(textureLod(u_before_tx, in_layer(u_field.other, uvw, 0), 0.0).a, 1e-6);
    for (int i = 0; i < kCount; ++i)
        g_light[i] += textureLod(u_before_tx, in_layer(u_field.other, uvw, i), 0.0).rgb / seen;
}

void main()
{
    ivec3 node = own_node();
    if (any(greaterThanEqual(node, node_count())))
        return;
    for (int i = 0; i < kCount; ++i)
        g_light[i] = kOwn ? vec3(0.0) : texelFetch(u_first_tx, node + layer_of(i), 0).rgb;
    if (!kFirst) {
        FOR_PAIRS_OF_26(GATHER, 0)
        g_light[0] += g_more / kMean0;
    }
    if (kBefore)
        add_before(node);
    if (kOwn) {
        imageStore(u_kept_img, node, vec4(g_light[0] * kMean0, 0.0));
        return;
    }
    if (!kTail)
        imageStore(u_mean_img, node, pack_light(g_light[0] * kMean0, node));
    vec4 albedo = texelFetch(u_albedo_tx, node, 0);
    vec3 got = albedo.rgb * g_light[0] * kMean0;
    vec3 more = vec3(0.0);
    if (kTail)
        more = guess(node) - got;
    else if (kKeeps && !kFirst)
        more = next_order(node, got, albedo.rgb) - got;
    if (kMean)
        return;
    vec3 peak = forward_peak_by_rest(albedo.rgb, albedo.a, u_field.straight_on);
    float power = 1.0;
    int i = 0;
    for (int l = 0; l < kBands; ++l) {
        for (; i < kHarmonics[l]; ++i)
            g_light[i] *= albedo.rgb * rest_of_band(power, peak);
        power *= albedo.a;
    }
    FOR_PAIRS_OF_26(SCATTER, 0)
    if (kKeeps) {
        int next = kFirst || kTail ? 0 : u_field.slot + 1;
        imageStore(u_kept_img, node + layer_of(2 * next), vec4(g_stored / (4.0 * 3.14159265), 0.0));
    }
}
