// Optical depth of the marched media towards a sun. The nodes stand in columns along its light, so that one sum that
// runs down a column is the depth of each: the planes between nodes are those of the lattice, the columns are sheared
// against it. A column that leaves the lattice on one side comes in again, empty, on the other. What the texture holds
// is in src/light/depth_layers.h.
//   in   the media, the columns of one layer
//   out  optical depth, one layer of the texture
#include "scene/light_volumes.glsl"

layout(local_size_x = COLUMN_GROUP, local_size_y = COLUMN_GROUP) in;
layout(binding = 0) writeonly uniform image3D u_depth_img;

// What of a segment of a column is in the lattice: from and to, of its length.
vec2 inside(vec3 from, vec3 way)
{
    vec2 t = ray_box(from, way, vec3(0.0), u_volumes.depth.last);
    return clamp(t, 0.0, 1.0);
}

void main()
{
    const float kMost = 6e4;  // of a 16-bit float; an infinity times a weight of 0 would be none
    SunColumns columns = u_volumes.filled;
    vec3 period = u_volumes.depth_period;
    ivec3 size = ivec3(period) + 1;
    int axis = columns.axis, a = (axis + 1) % 3, b = (axis + 2) % 3;
    ivec2 column = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, u_volumes.first_slice);
    if (column.x >= size[a] - 1 || column.y >= size[b] - 1)
        return;

    int planes = size[axis] - 1;
    bool to_last = columns.to_last != 0;
    vec3 way = to_last ? -columns.shear : columns.shear;  // from one node of a column to the next, away from the light
    way[axis] = to_last ? -1.0 : 1.0;
    float length_of_way = length(mat3(u_volumes.depth.world_from_node) * way);
    ivec3 layer = ivec3(0, 0, u_volumes.layer * size.z);
    volume_t tau = volume_t(0.0);
    vec2 turn_before = vec2(0.0);
    for (int i = 0; i < planes; ++i) {
        int k = to_last ? planes - 3 - i : i - 2;  // from 2 nodes before the lattice to 1 after it, or the other way
        // How often the column has come in again.
        vec2 shear = vec2(columns.shear[a], columns.shear[b]) * float(k);
        vec2 around = vec2(period[a], period[b]);
        vec2 turn = ceil((-2.0 - shear - vec2(column)) / around);
        vec3 node;
        node[axis] = float(k);
        vec2 lateral = vec2(column) + turn * around + shear;
        node[a] = lateral.x;
        node[b] = lateral.y;
        if (i == 0 || turn != turn_before) {
            tau = volume_t(0.0);
        } else {
            vec3 from = node - way;
            vec2 t = inside(from, way);
            if (t.x < t.y) {
                volume_t sum = volume_t(0.0);
                for (int s = 0; s < u_volumes.samples; ++s) {
                    vec3 at = from + way * mix(t.x, t.y, (float(s) + 0.5) / float(u_volumes.samples));
                    extinction_t sigma_t = marched_extinction((u_volumes.depth.world_from_node * vec4(at, 1.0)).xyz);
#ifdef VOLUME_RGB
                    sum += vec3(sigma_t);
#else
                    sum += dot(vec3(sigma_t), vec3(1.0 / 3.0));
#endif
                }
                tau += sum * ((t.y - t.x) * length_of_way / float(u_volumes.samples));
            }
        }
        turn_before = turn;

        // The first of each axis is there again at its end, where a fetch between the last and the first needs it.
        ivec3 texel;
        texel[axis] = k < 0 ? k + planes : k;
        texel[a] = column.x;
        texel[b] = column.y;
        bvec3 first = equal(texel, ivec3(0));
        vec4 value = vec4(min(vec3(tau), vec3(kMost)), 0.0);
        for (int copy = 0; copy < 8; ++copy) {
            bvec3 moved = bvec3((copy & 1) != 0, (copy & 2) != 0, (copy & 4) != 0);
            if (all(lessThanEqual(ivec3(moved), ivec3(first))))
                imageStore(u_depth_img, texel + ivec3(moved) * (size - 1) + layer, value);
        }
    }
}
