// What the steps that carry light through a lattice have in common.
//
// A way is walked by as many chains as one slice across it has nodes. A chain that leaves the lattice on one side goes
// on at the other, where light enters anew: each node is met once, and all chains are of the same length, whichever line the nodes that they go to are nearest to.
#include "shared/bindings.h"
#include "shared/field_nodes.h"
#include "shared/field_params.h"
#include "shared/sky_map_params.h"
#include "lib/lattice.glsl"
#include "lib/walls.glsl"

layout(std140, binding = FIELD_BLOCK) uniform Field { FieldParams u_field; };
layout(binding = FIELD_CROSSED_UNIT) uniform usampler3D u_crossed_tx;

// A place from its coordinate along an axis and those along the next two, and back.
ivec3 from_axes(int axis, ivec3 q) { return axis == 0 ? q : axis == 1 ? q.zxy : q.yzx; }
ivec3 to_axes(int axis, ivec3 q) { return axis == 0 ? q : axis == 1 ? q.yzx : q.zxy; }
vec3 along_axes(int axis, vec3 q) { return axis == 0 ? q : axis == 1 ? q.yzx : q.zxy; }

// Where media are looked up for a place in nodes. A medium may end at the lattice's faces, and on them it would be a
// matter of rounding whether there is any.
vec3 place_of(vec3 q)
{
    const float kRim = 1e-3;
    vec3 within = clamp(q, vec3(kRim), u_field.nodes.last - kRim);
    return (u_field.nodes.world_from_node * vec4(within, 1.0)).xyz;
}

// Read once: llvmpipe gathers a block's numbers lane by lane, and again on each turn of a loop.
ivec3 g_node_count = ivec3(u_field.nodes.last) + 1;
int g_first = u_field.first;
ivec3 node_count() { return g_node_count; }

// Where the images of several ways or harmonics have those of the k-th.
ivec3 layer_of(int k) { return ivec3(0, 0, k * node_count().z); }

// And where the image of all ways of a batch has the k-th: they stand beside each other in rows, since no edge of a
// texture may be too long.
ivec3 way_of(int k) { return ivec3(k & (FIELD_WAYS_A_ROW - 1), 0, k / FIELD_WAYS_A_ROW) * node_count(); }

const bool kPrecise = false;  // variant: see pack_light()

// Of a way that ends inside of a surface, instead of what surfaces let through.
const float kInside = 1.5;

// Radiance along a way, as floats without a sign, of 13, 13 and 12 bits behind the point, and what surfaces let through
// of the world's in halves, or kInside. Half as many bits: where a CPU draws, storing texels is what takes the time.
uvec4 pack_way(vec3 light, float open)
{
    const uvec3 kBits = uvec3(10, 10, 11);
    uvec3 bits = floatBitsToUint(abs(max(light, vec3(0.0))));
    bits = (bits + (uvec3(1) << (kBits - 1))) >> kBits;
    return uvec4(bits.r | bits.g << 21, bits.g >> 11 | bits.b << 10 | uint(2.0 * open) << 30, 0u, 0u);
}

vec4 unpack_way(uvec2 texel)
{
    uvec3 bits = uvec3(texel.x & 0x1fffffu, texel.x >> 21 | (texel.y & 0x3ffu) << 11, texel.y >> 10 & 0xfffffu);
    return vec4(uintBitsToFloat(bits << uvec3(10, 10, 11)), 0.5 * float(texel.y >> 30));
}

// Radiance along a way that goes from order to order, as three numbers of 8 bits that share an exponent: a quarter as
// many, for the same reason. What is rounded is small beside what a mean of 26 ways leaves out, and as it is rounded up
// in one texel and down in the next (a low-discrepancy sequence: Roberts 2018, "The Unreasonable Effectiveness of
// Quasirandom Sequences", in three dimensions) it adds up to nothing, not even in the differences of orders.
// In thick media light hardly gets from node to node, and what does is told by small differences: kPrecise.
//   at: of the texel
uvec4 pack_light(vec3 light, ivec3 at)
{
    if (kPrecise)
        return pack_way(light, 0.0);
    const float kLeast = 1e-36, kMost = 1e37;
    light = clamp(light, vec3(0.0), vec3(kMost));
    // Of a number that is rounded up to the next power of two its exponent.
    uint exponent = floatBitsToUint(max(max(light.r, max(light.g, light.b)), kLeast) * (1.0 + 1.0 / 512.0)) >> 23;
    float round_up = fract(dot(vec3(at), vec3(0.8191725, 0.6710436, 0.5497005)));
    uvec3 bits = min(uvec3(light * uintBitsToFloat((261u - exponent) << 23) + round_up), uvec3(255u));
    return uvec4(bits.r | bits.g << 8 | bits.b << 16 | exponent << 24, 0u, 0u, 0u);
}

vec3 unpack_light(uvec2 texel)
{
    if (kPrecise)
        return unpack_way(texel).rgb;
    return vec3(texel.x & 255u, texel.x >> 8 & 255u, texel.x >> 16 & 255u) *
           uintBitsToFloat(((texel.x >> 24) - 7u) << 23);
}

// What surfaces do to a way between a node and the one before it.
struct Crossing {
    bool is_crossed;  // one lies there
    bool is_left;     // and of a solid, whose inside is there
    float open;  // where the way enters the lattice, what of the light those beyond leave: of two lines what reaches it
};

// Of way k of the batch; light/crossings.comp.
Crossing crossing_at(ivec3 node, int k)
{
    int number = g_first + k;
    uvec4 bits = texelFetch(u_crossed_tx, node + layer_of(number >> 5), 0) >> uint(number & 31) & 1u;
    return Crossing(bits.x != 0u, bits.w != 0u, 1.0 - 0.5 * float(bits.y + bits.z));
}

// Whether a surface lies there, of all near ways, as bits of a float that goes beside what the medium is at a node: never
// of one that is no number, or so small that it might be taken for 0.
const uint kNumber = 0x40000000u;
float crossed_near(ivec3 node) { return uintBitsToFloat(kNumber | texelFetch(u_crossed_tx, node, 0).x); }
bool is_crossed_near(float crossed, int k) { return (floatBitsToUint(crossed) >> uint(k) & 1u) != 0u; }

// What surfaces let through of the part of the sky that a way, the k-th of all, stands for: what light/sky_share.comp
// tells of it, or `open`, where that tells nothing.
float share_of_sky(usampler3D shares_tx, ivec3 node, int k, float open)
{
    uint share = texelFetch(shares_tx, node + way_of(k), 0).r;
    return share == uint(SKY_UNKNOWN) ? open : float(share) / float(SKY_SHARES);
}

// For places between nodes: what is at a node counts as much as an optical depth of this between it and its neighbours.
const float kPoint = 0.25;

// Of nodes along a way: one in each slice.
struct Chain {
    int slice;
    ivec3 node;
    bool enters;  // there is no node before this one
    ivec2 start;  // across, in slice 0
    ivec2 lap;    // how often it has left the lattice, across
};

bool is_in(Chain chain, FieldWay way) { return chain.slice < to_axes(way.axis, node_count()).x; }

// Nodes that a line along the way has gone across at a slice.
ivec2 across_at(FieldWay way, int slice) { return ivec2(floor(way.slope * float(slice) + 0.5)); }

void place(inout Chain chain, FieldWay way)
{
    ivec3 count = to_axes(way.axis, node_count());
    ivec2 across = chain.start + across_at(way, chain.slice);
    ivec2 lap = ivec2(floor((vec2(across) + 0.5) / vec2(count.yz)));
    int along = way.forward > 0.0 ? chain.slice : count.x - 1 - chain.slice;
    chain.node = from_axes(way.axis, ivec3(along, across - lap * count.yz));
    chain.enters = chain.slice == 0 || lap != chain.lap;
    chain.lap = lap;
}

Chain first_of_chain(FieldWay way, ivec2 start)
{
    ivec3 count = to_axes(way.axis, node_count());
    Chain chain = Chain(any(greaterThanEqual(start, count.yz)) ? count.x : 0, ivec3(0), true, start, ivec2(0));
    place(chain, way);
    return chain;
}

void go_on(inout Chain chain, FieldWay way)
{
    ++chain.slice;
    place(chain, way);
}
