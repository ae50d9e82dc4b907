// Carries what surfaces send on through a lattice along each way of a batch.
//   in   sigma_t of the marched media; what surfaces cross, and what they send on
//   out  radiance [W/m^2/sr], a way's nodes after each other; alpha: kInside where a way ends inside of a surface
#include "light/field.glsl"
#include "light/faces.glsl"
#include "scene/light_volumes.glsl"

// Variant
const bool kClear = false;    // the media don't dim it
const bool kMarched = false;  // there are some without a closed form
const bool kBeyond = false;   // surfaces within the lattice send nothing

layout(local_size_x = 8, local_size_y = 8) in;
layout(rg32ui, binding = 0) writeonly uniform uimage3D u_ways_img;
layout(binding = FIELD_SIGMA_T_UNIT) uniform sampler3D u_sigma_t_tx;
layout(binding = WALLS_UNIT) uniform sampler3D u_walls_tx;
layout(binding = FACES_UNIT) uniform usampler3D u_faces_tx;
layout(binding = FACE_LIGHT_UNIT) uniform sampler3D u_face_light_tx;
layout(binding = BEYOND_UNIT) uniform sampler2DArray u_beyond_tx;

// What the last surface that was met sends, and what dims that.
struct Bounced {
    vec3 radiance;
    vec3 tau;
    float range;  // metres
};

bool is_face_met(ivec3 node, vec3 course, inout vec3 radiance)
{
    float nearest = 1e9;
    for (int axis = 0; axis < 3; ++axis) {
        float size = abs(course[axis]);
        int layer = 2 * axis + (course[axis] > 0.0 ? 0 : 1);
        if (size < 1e-3)
            continue;
        uint word = texelFetch(u_faces_tx, node + layer_of(layer), 0).r;
        if (word == kNoFace || unpack_face(word).before / size >= nearest)
            continue;
        nearest = unpack_face(word).before / size;
        radiance = texelFetch(u_face_light_tx, node + layer_of(layer), 0).rgb;
    }
    return nearest < 1e9;
}

// Of the surface between a node and the one before it. A surface that stands askew may meet none of the node's axes:
// then those of the nodes before it are asked, which are on the same side as long as nothing is met.
vec3 radiance_of_face(ivec3 node, vec3 course)
{
    vec3 radiance = vec3(0.0);
    for (int i = 0; i < 4 && !kBeyond; ++i) {
        if (any(lessThan(node, ivec3(0))) || any(greaterThanEqual(node, node_count())) ||
            is_face_met(node, course, radiance))
            break;
        int axis = i % 3;
        if (abs(course[axis]) > 1e-3)
            node[axis] -= course[axis] > 0.0 ? 1 : -1;
    }
    return radiance;
}

Bounced from_beyond(Chain chain, FieldWay way, int k, ivec3 count)
{
    ivec2 line = chain.start - chain.lap * count.yz - way.first_line;
    Bounced bounced = Bounced(vec3(0.0), vec3(0.0), 0.0);
    for (int part = 0; part < 2; ++part) {
        vec4 light = texelFetch(u_beyond_tx, ivec3(line, 2 * (u_field.first + k) + part), 0);
        bounced.radiance += 0.5 * light.rgb;
        bounced.range = max(bounced.range, light.a);
    }
    return bounced;
}

vec3 arriving(Bounced bounced, vec3 p, vec3 wi)
{
    if (bounced.radiance == vec3(0.0) || kClear)
        return bounced.radiance;
    return bounced.radiance * exp(-bounced.tau - vec3(closed_depth(p, wi, bounced.range)));
}

void main()
{
    int k = int(gl_GlobalInvocationID.z);
    FieldWay way = u_field.ways[k];
    ivec3 count = to_axes(way.axis, node_count());
    vec3 course = vec3(from_axes(way.axis, ivec3(1, 0, 0))) * way.forward +
                  vec3(from_axes(way.axis, ivec3(0, 1, 0))) * way.slope.x +
                  vec3(from_axes(way.axis, ivec3(0, 0, 1))) * way.slope.y;
    Chain chain = first_of_chain(way, ivec2(gl_GlobalInvocationID.xy));
    Bounced bounced = Bounced(vec3(0.0), vec3(0.0), 0.0);
    bool inside = false;
    vec3 old_sigma_t = vec3(0.0);
    for (; is_in(chain, way); go_on(chain, way)) {
        ivec3 node = chain.node;
        vec3 sigma_t = !kClear && kMarched ? texelFetch(u_sigma_t_tx, node, 0).rgb : vec3(0.0);
        vec3 tau = 0.5 * way.metres * (sigma_t + old_sigma_t);
        if (chain.enters) {
            bounced = from_beyond(chain, way, k, count);
            inside = false;
        } else {
            bounced.tau += tau;
            bounced.range += way.metres;
        }
        // A line goes past a node at up to half a node: see light/world.comp. If a surface lies between the two, the node
        // beyond it is on the line's side.
        vec2 off = way.slope * float(chain.slice) - vec2(across_at(way, chain.slice));
        Walls walls = walls_of(u_walls_tx, node, node_count().z);
        ivec3 on_line = node;
        Crossing crossing = crossing_at(node, k);
        int between = -1;
        bool is_of_face = false;
        for (int i = 0; i < 2 && between < 0; ++i) {
            int axis = (way.axis + 1 + i) % 3;
            int layer = 2 * axis + (off[i] > 0.0 ? 1 : 0);
            if ((off[i] > 0.0 ? walls.up[axis] : walls.down[axis]) >= abs(off[i]) - 1e-3)
                continue;
            between = layer;
            on_line[axis] += off[i] > 0.0 ? 1 : -1;
            is_of_face = off[i] * way.slope[i] < 0.0;
            if (is_of_face || !crossing.is_crossed || (way.forward > 0.0 ? walls.down : walls.up)[way.axis] > 1.0)
                continue;
            // Another one stands between the node and the one behind it.
            between = 2 * way.axis + (way.forward > 0.0 ? 0 : 1);
            is_of_face = true;
        }
        Bounced before = bounced;
        if (crossing.is_crossed) {
            // Where on the way is not known: half of it.
            bounced =
                Bounced(radiance_of_face(on_line, course), chain.enters ? vec3(0.0) : 0.5 * tau, 0.5 * way.metres);
            inside = !crossing.is_left;
        }
        Bounced here = bounced;
        if (is_of_face && kBeyond)
            here = Bounced(vec3(0.0), vec3(0.0), 0.0);
        else if (is_of_face)
            here = Bounced(texelFetch(u_face_light_tx, node + layer_of(between), 0).rgb, vec3(0.0), 0.0);
        else if (between >= 0 && crossing.is_crossed)
            here = before;
        vec3 light = arriving(here, node_position(u_field.nodes, node), way.wi);
        imageStore(u_ways_img, node + way_of(k), pack_way(light, between < 0 && inside ? kInside : 0.0));
        old_sigma_t = sigma_t;
    }
}
