// What media scatter to nodes, gathered along rays through each part of the far sides of their box: of the few ways that
// light is carried along from node to node, a floor would show each.
//   in   surfaces' walls, with the clearance; sigma_t; what is scattered into the near ways
//   io   coefficients of light, to which this is added; alpha of the first: 0 in nodes inside of surfaces
#include "light/field_listed.glsl"
#include "light/lattice_ray.glsl"
#include "light/way_pairs.glsl"
#include "lib/corner_angle.glsl"
#include "shared/spherical_harmonics.h"

const int kBands = 1;  // variant

const int kCount = kHarmonics[kBands - 1];

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(rgba32f, binding = 0) uniform image3D u_light_img;
layout(binding = FIELD_SOURCE_UNIT) uniform usampler3D u_source_tx;
layout(binding = FIELD_SIGMA_T_UNIT) uniform sampler3D u_sigma_t_tx;

// Of the near ways, which are the batch, the nearest one.
int near_way(vec3 wi)
{
    float most = 0.0;
    int way = 0;
#define LOOK_AT(k)                                                 \
    {                                                              \
        float along = dot(u_field.ways[k].wi, wi);                 \
        way = abs(along) > most ? (along > 0.0 ? k : k + 1) : way; \
        most = max(most, abs(along));                              \
    }
    FOR_PAIRS_OF_26(LOOK_AT, 0)
    return way;
}

// The three near ways around a direction, an axis, an edge and a corner of a cube, and the parts that it has of them.
struct WaysAround {
    ivec3 ways[3];  // as way_of() has them
    vec3 parts;
};

WaysAround ways_around(vec3 wi)
{
    vec3 size = abs(wi);
    float most = max(size.x, max(size.y, size.z)), least = min(size.x, min(size.y, size.z));
    float middle = size.x + size.y + size.z - most - least;
    vec3 corner = mix(vec3(-1.0), vec3(1.0), greaterThan(wi, vec3(0.0)));
    WaysAround around;
    for (int i = 0; i < 3; ++i)
        around.ways[i] = way_of(near_way(corner * (i == 0   ? step(vec3(most), size)
                                                   : i == 1 ? step(vec3(middle), size)
                                                            : vec3(1.0))));
    around.parts = vec3(most - middle, sqrt(2.0) * (middle - least), sqrt(3.0) * least);
    around.parts /= around.parts.x + around.parts.y + around.parts.z;
    return around;
}

// Radiance that comes to a node along a ray, from where that enters the media's box to where it leaves it, or meets a
// surface. range: metres
vec3 arriving(ivec3 from, vec3 wi, vec2 range, float shift)
{
    const float kMostSamples = 10.0;
    const float kStep = 1.5;  // nodes
    vec3 course = off_axes(node_way(u_field.nodes, wi));
    Met met = first_met(from, course, range.y);
    if (met.layer >= 0)
        range.y = min(range.y, met.t);
    float nodes = (range.y - range.x) * length(course);
    float samples = nodes > 0.0 ? clamp(ceil(nodes / kStep), 1.0, kMostSamples) : 0.0;
    float metres = (range.y - range.x) / max(samples, 1.0);
    WaysAround around = ways_around(wi);
    vec3 through = vec3(1.0), light = vec3(0.0);
    for (float i = shift; i < samples; ++i) {
        vec3 q = vec3(from) + course * (range.x + metres * i);
        ivec3 node = clamp(ivec3(q + 0.5), ivec3(0), node_count() - 1);
        vec3 piece = texelFetch(u_sigma_t_tx, node, 0).rgb * metres;
        vec3 source = vec3(0.0);
        for (int k = 0; k < 3; ++k)
            source += around.parts[k] * unpack_light(texelFetch(u_source_tx, node + around.ways[k], 0).rg);
        vec3 after = through * exp(-piece);
        light += (through - after) * source;
        through = after;
    }
    return light;
}

void main()
{
    const float kParts = 8.0, kPartsAfar = 3.0;  // along the box's longest edge, far from surfaces that look nodes up
    const int kAfar = 3;                         // nodes
    ivec3 node = own_node();
    if (any(greaterThanEqual(node, node_count())))
        return;
    vec3 light[kCount];
    for (int i = 0; i < kCount; ++i)
        light[i] = vec3(0.0);
    float outside = imageLoad(u_light_img, node).a;
    bool is_afar = unpack_clearance(texelFetch(u_crossed_tx, node, 0).rg, bvec3(false)).nodes >= kAfar;
    vec3 p = node_position(u_field.nodes, node);
    // With all of the cells of which some is in it, as those have what is there on the mean.
    vec3 low = (u_field.nodes.world_from_node * vec4(u_field.media_low - 0.5, 1.0)).xyz,
         high = (u_field.nodes.world_from_node * vec4(u_field.media_high + 0.5, 1.0)).xyz;
    vec3 size = high - low;
    float part = max(size.x, max(size.y, size.z)) / (is_afar ? kPartsAfar : kParts);
    int faces = outside > 0.0 ? min(u_field.count, 6) : 0;  // never unrolled, which would take long to compile
    float rays = 0.5;
    for (int face = 0; face < faces; ++face) {
        int axis = face >> 1, u = axis == 2 ? 0 : axis + 1, v = axis == 0 ? 2 : axis - 1;
        float side = (face & 1) != 0 ? 1.0 : -1.0;
        float height = side * ((side > 0.0 ? high : low)[axis] - p[axis]);
        if (height <= 0.0)
            continue;
        vec2 parts = max(ceil(vec2(size[u], size[v]) / part - 1e-3), vec2(1.0));
        vec2 edges = vec2(size[u], size[v]) / parts;
        for (float j = 0.0; j < parts.y; ++j)
            for (float i = 0.0; i < parts.x; ++i) {
                vec2 begin = vec2(low[u] - p[u], low[v] - p[v]) + vec2(i, j) * edges, end = begin + edges;
                float angle = corner_angle(end, height) - corner_angle(vec2(begin.x, end.y), height) -
                              corner_angle(vec2(end.x, begin.y), height) + corner_angle(begin, height);
                vec3 way;
                way[axis] = side * height;
                way[u] = 0.5 * (begin.x + end.x);
                way[v] = 0.5 * (begin.y + end.y);
                float range = length(way);
                vec3 wi = way / range;
                float enters = max(ray_box(p, wi, low, high).x, 0.0);
                // Samples stand elsewhere along the next ray, by a sequence that is even.
                vec3 arrives = max(angle, 0.0) * arriving(node, wi, vec2(enters, range), fract(rays * 0.61803399));
                rays += 1.0;
                for (int k = 0; k < kCount; ++k)
                    light[k] += spherical_harmonic(k, wi) * arrives;
            }
    }
    for (int i = 0; i < kCount; ++i) {
        ivec3 at = node + layer_of(i);
        imageStore(u_light_img, at, imageLoad(u_light_img, at) + vec4(light[i], 0.0));
    }
}
