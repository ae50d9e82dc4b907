// Carries the world's light through a lattice along each way of a batch: what the media let through, until a surface
// is met.
//   in   sigma_t at the nodes, and what surfaces cross
//   out  radiance [W/m^2/sr], a way's nodes after each other; alpha: what of it surfaces let through
#include "light/field.glsl"
#include "scene/light_volumes.glsl"

// Variant
const bool kClear = false;     // the media don't dim it
const bool kMarched = false;   // some dim it by their extinction at the nodes
const bool kClosed = false;    // and some by a closed form
const bool kSurfaces = false;  // surfaces stand in the way
const bool kShares = false;    // light/sky_share.comp tells what they let through
const bool kMeans = false;     // out: the mean over what lies between a node and its neighbours, by what dims there
const bool kTaken = false;     // as much as a node takes in on either side it sends out there

layout(local_size_x = 8, local_size_y = 8) in;
layout(rg32ui, binding = 0) writeonly uniform uimage3D u_ways_img;
layout(binding = 1) writeonly uniform uimage3D u_means_img;
layout(binding = FIELD_SIGMA_T_UNIT) uniform sampler3D u_sigma_t_tx;
layout(binding = WALLS_UNIT) uniform sampler3D u_walls_tx;
layout(binding = FIELD_EMISSION_UNIT) uniform usampler3D u_shares_tx;  // nothing is emitted here

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

void main()
{
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
    extinction_t old_mean = extinction_t(0.0);
    extinction_t old_piece = extinction_t(0.0);
    float old_share = 0.0;
    ivec3 old_node = ivec3(0);
    bool first = true, alone = true;
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
        } else if (!kClear && kMarched) {
            tau += 0.5 * way.metres * (sigma_t + old_sigma_t);
        }
        before = visible;
        if (crossing.is_crossed) {
            visible = 0.0;
            inside = !crossing.is_left;
        }
        float open = kSurfaces && !kMeans ? visible_at_node(chain, way, crossing.is_crossed, visible, before) : visible;
        bool is_inside = open == 0.0 && inside;
        if (kShares && !is_inside)
            open = share_of_sky(u_shares_tx, node, k, open);
        float share = open;
        extinction_t through = extinction_t(open);
        if (is_inside)
            open = kInside;
        extinction_t depth = tau;
        if (!kClear && kClosed)
            depth += extinction_t(closed_depth(node_position(u_field.nodes, node), way.wi, kSunRange));
        if (!kClear)
            through *= exp(-depth);
        if (kMeans) {
            // Between two nodes light falls off evenly in optical depth, and what they see of the sky goes from the one's to
            // the other's; or it is the one's before a surface.
            bool is_cut = kShares ? crossing.is_crossed : visible < before;
            extinction_t mean =
                chain.enters || is_cut ? through : old_through * slab_weight(max(depth - old_depth, 0.0));
            if (kShares && !chain.enters && !is_cut)
                mean = extinction_t(0.5 * (old_share + share)) * exp(-old_depth) *
                       slab_weight(max(depth - old_depth, 0.0));
            old_share = share;
            extinction_t begin = is_cut ? old_through : mean;
            extinction_t piece = chain.enters ? extinction_t(0.0) : max(depth - old_depth, 0.0);
            if (!first)
                imageStore(
                    u_means_img, old_node + way_of(k),
                    pack_light(way.entry * (chain.enters ? old_mean
                                            : alone      ? begin
                                                         : mix(old_mean, begin,
                                                          kTaken ? part_of_side(piece, old_piece) : extinction_t(0.5))),
                               old_node + way_of(k)));
            alone = chain.enters;
            old_mean = mean;
            old_piece = piece;
        } else {
            imageStore(u_ways_img, node + way_of(k), pack_way(way.entry * through, open));
        }
        first = false;
        old_node = node;
        old_through = through;
        old_depth = depth;
        old_sigma_t = sigma_t;
    }
    if (kMeans && !first)
        imageStore(u_means_img, old_node + way_of(k), pack_light(way.entry * old_mean, old_node + way_of(k)));
}
