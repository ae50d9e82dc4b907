// Optical depth of the marched media towards a sun. The nodes stand in columns along its light, so that one sum that
// runs down a column is the depth of each: the planes between nodes are those of the lattice, the columns are sheared
// against it. A column that leaves the lattice on one side comes in again, empty, on the other.
//   in   the media, the columns of one layer
//   out  optical depth, one layer of the texture
#include "lib/channels.glsl"
#include "scene/light_volumes.glsl"

layout(local_size_x = COLUMN_GROUP, local_size_y = COLUMN_GROUP) in;
layout(binding = 0) writeonly uniform image3D u_depth_img;

// Coordinates along the columns' axis and the next two, and back.
int g_axis = u_volumes.filled.axis;
vec3 to_columns(vec3 v) { return g_axis == 0 ? v : g_axis == 1 ? v.yzx : v.zxy; }
ivec3 from_columns(ivec3 v) { return g_axis == 0 ? v : g_axis == 1 ? v.zxy : v.yzx; }

// The mean extinction on the way between two nodes of a column, over all of it.
volume_t mean_extinction(HeldMedia held, int samples, mat4 world_from_column, vec3 from, vec3 way, vec3 inverse_way,
                         vec3 last)
{
    // What of it is in the lattice.
    vec3 a = -from * inverse_way, b = (last - from) * inverse_way;
    vec3 enter = min(a, b), leave = max(a, b);
    float begin = clamp(max(enter.x, max(enter.y, enter.z)), 0.0, 1.0);
    float end = clamp(min(leave.x, min(leave.y, leave.z)), 0.0, 1.0);
    volume_t sum = volume_t(0.0);
    for (int i = 0; begin < end && i < samples; ++i) {
        vec3 at = from + way * mix(begin, end, (float(i) + 0.5) / float(samples));
        extinction_t sigma_t = marched_extinction((world_from_column * vec4(at, 1.0)).xyz, held);
#ifdef VOLUME_RGB
        sum += vec3(sigma_t);
#else
        sum += mean(sigma_t);
#endif
    }
    return sum * ((end - begin) / float(samples));
}

// The first of each axis is there again at its end, where a fetch between the last and the first needs it.
void store(ivec3 texel, vec4 value, ivec3 period, ivec3 layer)
{
    imageStore(u_depth_img, texel + layer, value);
    if (all(greaterThan(texel, ivec3(0))))
        return;
    for (int copy = 1; copy < 8; ++copy) {
        ivec3 moved = ivec3(copy & 1, copy >> 1 & 1, copy >> 2);
        if (all(lessThanEqual(moved, ivec3(equal(texel, ivec3(0))))))
            imageStore(u_depth_img, texel + moved * period + layer, value);
    }
}

void main()
{
    const float kMost = 6e4;  // of a 16-bit float; an infinity times a weight of 0 would be none
    const float kNever = 1e30;
    ivec2 column = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, u_volumes.first_slice);
    vec3 period = to_columns(u_volumes.depth_period);
    if (any(greaterThanEqual(vec2(column), period.yz)))
        return;
    // From one node of a column to the next, away from the light.
    bool to_last = u_volumes.filled.to_last != 0;
    vec2 shear = to_columns(u_volumes.filled.shear).yz;
    vec3 way = to_last ? -vec3(1.0, shear) : vec3(1.0, shear);
    vec3 inverse_way = mix(1.0 / way, vec3(kNever), lessThan(abs(way), vec3(1.0 / kNever)));
    mat4 world_from_column = u_volumes.depth.world_from_node;
    if (g_axis == 1)
        world_from_column =
            mat4(world_from_column[1], world_from_column[2], world_from_column[0], world_from_column[3]);
    if (g_axis == 2)
        world_from_column =
            mat4(world_from_column[2], world_from_column[0], world_from_column[1], world_from_column[3]);
    float metres = length(mat3(world_from_column) * way);
    vec3 last = to_columns(u_volumes.depth.last);
    ivec3 texels = ivec3(u_volumes.depth_period);
    ivec3 layer = ivec3(0, 0, u_volumes.layer * (texels.z + 1));
    int samples = u_volumes.samples;
    HeldMedia held = held_media();

    volume_t tau = volume_t(0.0);
    vec2 lap_before = vec2(0.0);
    int planes = int(period.x);
    for (int i = 0; i < planes; ++i) {
        int plane = to_last ? planes - 3 - i : i - 2;  // between two nodes before the lattice and one after it
        // How often the column has come in again.
        vec2 moved = shear * float(plane);
        vec2 lap = ceil((-2.0 - moved - vec2(column)) / period.yz);
        vec3 node = vec3(float(plane), vec2(column) + lap * period.yz + moved);
        if (i == 0 || lap != lap_before)
            tau = volume_t(0.0);
        else
            tau += metres * mean_extinction(held, samples, world_from_column, node - way, way, inverse_way, last);
        lap_before = lap;
        store(from_columns(ivec3(plane < 0 ? plane + planes : plane, column)), vec4(min(vec3(tau), vec3(kMost)), 0.0),
              texels, layer);
    }
}
