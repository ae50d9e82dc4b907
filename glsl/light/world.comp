// Carries the world's light through a lattice along each way of a batch: what the media let through, until a surface
// is met.
//   in   sigma_t at the nodes, and what surfaces cross
//   out  radiance [W/m^2/sr], a way's nodes after each other; alpha: what of it surfaces let through
#include "light/field.glsl"
#include "light/media_ends.glsl"
#include "scene/light_volumes.glsl"

// Variant
const bool kClear = false;     // the media don't dim it
const bool kMarched = false;   // some dim it by their extinction at the nodes
const bool kClosed = false;    // and some by a closed form
const bool kAmid = false;      // and wider media around the lattice do likewise
const bool kSurfaces = false;  // surfaces stand in the way
const bool kShares = false;    // light/sky_share.comp tells what they let through
const bool kEnds = false;      // media end at faces of a box
const bool kMeans = false;     // out: the mean over what lies between a node and its neighbours, by what dims there
const bool kTaken = false;     // as much as a node takes in on either side it sends out there
const bool kLooked = false;    // out: for places between nodes. The thicker it is there, the more of that mean.

layout(local_size_x = 8, local_size_y = 8) in;
layout(rg32ui, binding = 0) writeonly uniform uimage3D u_ways_img;
layout(binding = 1) writeonly uniform uimage3D u_means_img;
layout(binding = FIELD_SIGMA_T_UNIT) uniform sampler3D u_sigma_t_tx;
layout(binding = WALLS_UNIT) uniform sampler3D u_walls_tx;
layout(binding = FIELD_EMISSION_UNIT) uniform usampler3D u_shares_tx;  // nothing is emitted here

const bool kAround = kMeans || kLooked;  // what lies beyond a node counts too

// A line goes past a node at up to half a node. If a surface lies between the two, then what reaches the node is what the
// line had before that surface, or nothing, if it comes from behind it. Nothing, too, if the line has met another one
// first, as at the foot of a wall: then that stands between the node and the one behind it.
float visible_at_node(Chain chain, FieldWay way, bool is_crossed, float visible, float before)
{
    vec2 line = way.slope * float(chain.slice);
    vec2 off = line - vec2(across_at(way, chain.slice));
    if (off == vec2(0.0))
        return visible;
    Walls walls = walls_of(u_walls_tx, chain.node, node_count().z);
    for (int i = 0; i < 2; ++i) {
        int axis = (way.axis + 1 + i) % 3;
        float wall = off[i] > 0.0 ? walls.up[axis] : walls.down[axis];
        if (wall >= abs(off[i]) - 1e-3)
            continue;
        float behind = way.forward > 0.0 ? walls.down[way.axis] : walls.up[way.axis];
        return off[i] * way.slope[i] < 0.0 ? 0.0 : !is_crossed ? visible : behind <= 1.0 ? 0.0 : before;
    }
    return visible;
}

// What surfaces let through of the sky's light that comes from beyond faces in whose plane a way lies, of which they let
// through `open`: lower and higher along the next axis, and along the one after it. As much as of the way beside it that
// comes from there, where that enters the lattice.
vec4 open_beyond(ivec3 node, FieldWay way, float open)
{
    vec4 beyond = vec4(open);
    for (int i = 0; kSurfaces && i < 4; ++i) {
        int axis = (way.axis + 1 + (i >> 1)) % 3;
        int beside = way.beside >> (8 * i) & 255;
        if (way.slope[i >> 1] == 0.0 && kShares)
            beyond[i] = share_of_sky(u_shares_tx, node, beside, open);
        else if (way.slope[i >> 1] == 0.0 && node[axis] == ((i & 1) == 0 ? 0 : node_count()[axis] - 1))
            beyond[i] = crossing_at(node, beside - g_first).open;
    }
    return beyond;
}

// What is stored of a node: a sum of what gets through to it and to both sides of it, and of their weights.
struct Stored {
    ivec3 node;
    extinction_t light, weight;
    Beyond beyond;
    float open;
};

void add(inout Stored stored, extinction_t light, extinction_t weight)
{
    stored.light += weight * light;
    stored.weight += weight;
}

void store(Stored stored, int k)
{
    ivec3 at = stored.node + way_of(k);
    extinction_t through = stored.light / stored.weight;
    if (kEnds)
        through = through * stored.beyond.within + stored.beyond.open;
    vec3 light = u_field.ways[k].entry * through;
    if (kMeans)
        imageStore(u_means_img, at, pack_light(light, at));
    else
        imageStore(u_ways_img, at, pack_way(light, stored.open));
}

void main()
{
    const float kNone = 1e-9;    // of optical depth
    const float kFirst = 1e-12;  // where nothing lies on either side
    int k = int(gl_GlobalInvocationID.z);
    FieldWay way = u_field.ways[k];
    Chain chain = first_of_chain(way, ivec2(gl_GlobalInvocationID.xy));
    float visible = 1.0;
    float before = 1.0;
    bool inside = false;
    extinction_t tau = extinction_t(0.0);
    extinction_t old_sigma_t = extinction_t(0.0);
    extinction_t old_depth = extinction_t(0.0);
    extinction_t old_through = extinction_t(0.0);
    float old_share = 0.0;
    float gone = 0.0;
    Stored old = Stored(ivec3(0), extinction_t(0.0), extinction_t(0.0), Beyond(1.0, 0.0), 0.0);
    bool first = true;
    for (; is_in(chain, way); go_on(chain, way)) {
        ivec3 node = chain.node;
        extinction_t sigma_t = extinction_t(0.0);
        if (!kClear && kMarched)
            sigma_t = extinction_t(texelFetch(u_sigma_t_tx, node, 0).rgb);
        Crossing crossing = Crossing(false, false, 1.0);
        if (kSurfaces)
            crossing = crossing_at(node, k);
        if (chain.enters) {
            visible = crossing.open;
            inside = false;
            tau = extinction_t(0.0);
            if (kAmid)
                tau = extinction_t(closed_dimming(node_position(u_field.nodes, node), way.wi, kSunRange));
            gone = 0.0;
        } else if (!kClear && kMarched) {
            tau += 0.5 * way.metres * (sigma_t + old_sigma_t);
            gone += way.metres;
        }
        before = visible;
        if (crossing.is_crossed) {
            visible = 0.0;
            inside = !crossing.is_left;
        }
        float open = kSurfaces && !kMeans ? visible_at_node(chain, way, crossing.is_crossed, visible, before) : visible;
        bool is_inside = open == 0.0 && inside;
        if (kShares && !is_inside)
            open = share_of_sky(u_shares_tx, node, g_first + k, open);
        float share = open;
        extinction_t through = extinction_t(open);
        if (is_inside)
            open = kInside;
        extinction_t depth = tau;
        if (!kClear && kClosed)
            depth += extinction_t(closed_depth(node_position(u_field.nodes, node), way.wi, kSunRange));
        if (!kClear)
            through *= exp(-depth);
        Stored stored = Stored(node, extinction_t(0.0), extinction_t(0.0), Beyond(1.0, 0.0), open);
        if (kEnds)
            stored.beyond = beyond_ends(node, way, sigma_t, gone, kAround ? 1.0 : 0.0,
                                        is_inside ? vec4(0.0) : open_beyond(node, way, share));
        if (kAround && chain.enters)
            add(stored, through, extinction_t(kFirst));
        if (kAround && !chain.enters) {
            // Between two nodes light falls off evenly in optical depth, and what they see of the sky goes from the one's to
            // the other's; or it is the one's before a surface.
            bool is_cut = kShares ? crossing.is_crossed : visible < before;
            extinction_t piece = max(depth - old_depth, 0.0);
            extinction_t mean = old_through * slab_weight(piece);
            if (kShares)
                mean = extinction_t(0.5 * (old_share + share)) * exp(-old_depth) * slab_weight(piece);
            extinction_t weight = kLooked || kTaken ? piece + kNone : extinction_t(1.0);
            add(old, is_cut ? old_through : mean, weight);
            add(stored, is_cut ? through : mean, weight);
        }
        if (!kMeans)
            add(stored, through, extinction_t(kLooked ? kPoint : 1.0));
        if (!kAround)
            store(stored, k);
        else if (!first)
            store(old, k);
        first = false;
        old = stored;
        old_share = share;
        old_through = through;
        old_depth = depth;
        old_sigma_t = sigma_t;
    }
    if (kAround && !first)
        store(old, k);
}
