// What the tiles of a frame see of the media: a work group a box, which it projects and notes in all tiles that the box
// may be in. As see_media() of src/pass/step_tiles.cpp, sum by sum.
//   in   boxes of the media, part by part; lists of seen tiles and tiles of the picture with nothing in them
//   out  seen tiles of the march; tiles of the picture that are to be drawn
#include "pass/step_view.glsl"

layout(local_size_x = STEP_GROUP) in;
layout(std430, binding = STEP_BOXES_BUFFER) readonly buffer StepBoxes { StepBox u_boxes[]; };
layout(std430, binding = STEP_SEEN_BUFFER) buffer SeenTiles { SeenTile u_seen[]; };
layout(binding = STEP_TILES_IMAGE, rgba32ui) writeonly uniform uimage2D u_picture_tiles_img;

const int kCorners = 8;

shared dvec2 s_pixels[kCorners];
shared double s_view_z[kCorners];
shared bool s_before_eye[kCorners];

// In the order in which the CPU adds, and not contracted to other bits.
dvec4 transformed(dmat4 map, dvec4 v)
{
    precise dvec4 image = (map[0] * v.x + map[1] * v.y) + (map[2] * v.z + map[3] * v.w);
    return image;
}

// Numbers only grow: one that was read before another group's came is no harm.
void see(int tile, uvec2 slots, uint not_longest, uint most)
{
    uvec2 more = slots & ~uvec2(u_seen[tile].slots_low, u_seen[tile].slots_high);
    if (more.x != 0u)
        atomicOr(u_seen[tile].slots_low, slots.x);
    if (more.y != 0u)
        atomicOr(u_seen[tile].slots_high, slots.y);
    if (u_seen[tile].not_longest < not_longest)
        atomicMax(u_seen[tile].not_longest, not_longest);
    if (u_seen[tile].most < most)
        atomicMax(u_seen[tile].most, most);
}

void main()
{
    int part = int(gl_WorkGroupID.y), number = int(gl_WorkGroupID.x);
    if (number >= u_view.parts[part].y)
        return;
    StepBox box = u_boxes[u_view.parts[part].x + number];
    int lane = int(gl_LocalInvocationIndex);
    if (lane < kCorners) {
        dvec3 corner = dvec3((lane & 1) != 0 ? box.high.x : box.low.x, (lane & 2) != 0 ? box.high.y : box.low.y,
                             (lane & 4) != 0 ? box.high.z : box.low.z);
        dvec4 view = transformed(u_view.view_from_boxes[part], dvec4(corner, 1.0));
        dvec4 clip = transformed(u_view.clip_from_view, view);
        precise dvec2 pixel = (clip.xy / clip.w * 0.5 + 0.5) * u_view.picture;
        s_view_z[lane] = -view.z;
        s_before_eye[lane] = -view.z > u_view.near && clip.w > 0.0;
        s_pixels[lane] = pixel;
    }
    barrier();
    dvec2 low = s_pixels[0], high = low;
    dvec2 view_z = dvec2(s_view_z[0]);
    bool crosses = false;
    for (int i = 0; i < kCorners; ++i) {
        view_z = dvec2(min(view_z.x, s_view_z[i]), max(view_z.y, s_view_z[i]));
        low = min(low, s_pixels[i]);
        high = max(high, s_pixels[i]);
        crosses = crosses || !s_before_eye[i];
    }
    if (crosses) {
        low = dvec2(0.0);
        high = u_view.picture;
    }
    precise double margin = u_view.depth_rounding * (abs(view_z.x) + abs(view_z.y));
    view_z += dvec2(-margin, margin);
    if (view_z.y <= u_view.near)
        return;

    uvec2 slots = slots_between(view_z.x, view_z.y);
    uint not_longest = ~floatBitsToUint(float(box.low.w)), most = floatBitsToUint(float(box.high.w));
    ivec4 marched =
        tiles_between(low / u_view.scale - u_view.offset - u_view.slack,
                      high / u_view.scale - u_view.offset + u_view.slack, double(kLayerTile), u_view.march_tiles);
    ivec2 size = max(marched.zw - marched.xy + 1, ivec2(0));
    for (int i = lane; i < size.x * size.y; i += STEP_GROUP) {
        ivec2 at = marched.xy + ivec2(i % size.x, i / size.x);
        see(at.y * u_view.march_tiles.x + at.x, slots, not_longest, most);
    }
    precise double grow = u_view.reach * u_view.scale + u_view.slack;
    ivec4 drawn = tiles_between(low - grow, high + grow, double(kPictureTile), u_view.picture_tiles);
    size = max(drawn.zw - drawn.xy + 1, ivec2(0));
    for (int i = lane; i < size.x * size.y; i += STEP_GROUP)
        imageStore(u_picture_tiles_img, drawn.xy + ivec2(i % size.x, i / size.x), uvec4(1u, 0u, 0u, 0u));
}
