// What lamps send straight to the nodes: surfaces that shine and are so small that few of a lattice's lines meet them, or
// none.
//   in   surfaces' walls, with the clearance, and faces; sigma_t of the marched media; the lamps, a column each: middle,
//        and the number of the surface; half edges, and 1 where it is a box; areas as they are seen along the axes;
//        emission
//   out  coefficients [W/m^2/sr]; alpha: 0
#include "light/faces.glsl"
#include "light/lattice_ray.glsl"
#include "scene/light_volumes.glsl"
#include "shared/spherical_harmonics.h"

// Variant
const int kBands = 1;
const bool kClear = false;    // the media don't dim it
const bool kMarched = false;  // there are some without a closed form

const int kCount = kHarmonics[kBands - 1];

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(binding = 0) writeonly uniform image3D u_light_img;
layout(binding = FACE_MATERIALS_UNIT) uniform sampler2D u_lamps_tx;
layout(binding = FACES_UNIT) uniform usampler3D u_faces_tx;
layout(binding = FIELD_SIGMA_T_UNIT) uniform sampler3D u_sigma_t_tx;

struct Lamp {
    vec3 middle;  // eye-centred world [m]
    int surface;
    vec3 half_edges;  // [m]
    bool is_box;
    vec3 areas;  // seen along each axis [m^2]
    vec3 emission;
};

Lamp lamp_at(int i)
{
    vec4 place = texelFetch(u_lamps_tx, ivec2(i, 0), 0);
    vec4 size = texelFetch(u_lamps_tx, ivec2(i, 1), 0);
    return Lamp(place.xyz, int(place.w), size.xyz, size.w != 0.0, texelFetch(u_lamps_tx, ivec2(i, 2), 0).xyz,
                texelFetch(u_lamps_tx, ivec2(i, 3), 0).rgb);
}

// Of a box; of an ellipsoid, which others are taken for. A flat one is either.
float area_seen(Lamp lamp, vec3 wi)
{
    vec3 areas = abs(wi) * lamp.areas;
    return lamp.is_box ? areas.x + areas.y + areas.z : length(areas);
}

// Nothing stands before it: what is met is the lamp itself, or lies behind where the way comes to its box.
bool is_seen(Lamp lamp, ivec3 node, vec3 p, vec3 wi)
{
    const float kSlack = 0.02;  // nodes: of a lamp on a wall
    float begin = ray_box(p, wi, lamp.middle - lamp.half_edges, lamp.middle + lamp.half_edges).x;
    Met met = first_met(node, off_axes(node_way(u_field.nodes, wi)), begin);
    if (met.layer < 0 || met.t >= begin - kSlack * u_field.nodes.spacing)
        return true;
    return unpack_face(texelFetch(u_faces_tx, met.node + layer_of(met.layer), 0).r).surface == lamp.surface;
}

vec3 depth_to(vec3 p, vec3 wi, float metres)
{
    const int kSamples = 16;
    vec3 tau = vec3(closed_depth(p, wi, metres));
    if (!kMarched)
        return tau;
    vec3 from = node_at(u_field.nodes, p);
    vec3 course = node_way(u_field.nodes, wi);
    vec2 range = ray_box(from, course, u_field.media_low, u_field.media_high);
    range = vec2(max(range.x, 0.0), min(range.y, metres));
    float piece = max(range.y - range.x, 0.0) / float(kSamples);
    for (int i = 0; i < kSamples; ++i) {
        vec3 q = from + course * (range.x + piece * (float(i) + 0.5));
        tau += texelFetch(u_sigma_t_tx, clamp(ivec3(q + 0.5), ivec3(0), node_count() - 1), 0).rgb * piece;
    }
    return tau;
}

void main()
{
    const float kMost = 2.0 * 3.14159265;  // of the sphere that a lamp is seen in
    ivec3 node = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(node, node_count())))
        return;
    vec3 p = node_position(u_field.nodes, node);
    vec3 light[kCount];
    for (int i = 0; i < kCount; ++i)
        light[i] = vec3(0.0);
    int lamps = textureSize(u_lamps_tx, 0).x;
    for (int k = 0; k < lamps; ++k) {
        Lamp lamp = lamp_at(k);
        vec3 way = lamp.middle - p;
        float metres = max(length(way), 1e-6);
        vec3 wi = way / metres;
        if (!is_seen(lamp, node, p, wi))
            continue;
        vec3 sent = lamp.emission * min(area_seen(lamp, wi) / (metres * metres), kMost);
        if (!kClear)
            sent *= exp(-depth_to(p, wi, metres));
        for (int i = 0; i < kCount; ++i)
            light[i] += sent * spherical_harmonic(i, wi);
    }
    for (int i = 0; i < kCount; ++i)
        imageStore(u_light_img, node + layer_of(i), vec4(light[i], 0.0));
}
