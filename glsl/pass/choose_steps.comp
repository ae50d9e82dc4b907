// How long the steps of each tile are, by what it sees of the media and where lights are. As choose_steps() of
// src/pass/step_tiles.cpp, sum by sum.
//   in   seen tiles of pass/see_boxes.comp
//   out  a texel a tile of the march: shared/step_tile.h
#include "pass/step_view.glsl"

layout(local_size_x = PICTURE_GROUP, local_size_y = PICTURE_GROUP) in;
layout(std430, binding = STEP_SEEN_BUFFER) readonly buffer SeenTiles { SeenTile u_seen[]; };
layout(binding = STEP_TILES_IMAGE, rgba32ui) writeonly uniform uimage2D u_tiles_img;

// Metres, about, between a light and the ray of a pixel.
double from_ray(StepLight light, dvec2 pixel)
{
    precise dvec2 off = pixel - light.pixel;
    precise double square = off.x * off.x + off.y * off.y;
    precise double metres = light.metres * sqrt(square);
    return max(light.least, metres);
}

// Metres, about, that a light is at least from all that a tile holds.
double from_tile(StepLight light, dvec2 pixel, uvec2 slots)
{
    precise dvec2 off = pixel - light.pixel;
    precise double square = off.x * off.x + off.y * off.y;
    precise double beside = light.metres * (sqrt(square) - u_view.tile_radius);
    precise double before = slot_end(first_slot(slots)) - light.view_z;
    precise double behind = light.view_z - slot_end(end_of_slots(slots));
    return max(max(light.least, beside), max(before, behind));
}

void main()
{
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, u_view.march_tiles)))
        return;
    SeenTile seen = u_seen[at.y * u_view.march_tiles.x + at.x];
    HeldSlots held = HeldSlots(uvec2(seen.slots_low, seen.slots_high), uvec2(0u), double(0.0), double(0.0), double(0.0),
                               u_view.lit != 0);
    if (u_view.shafts_anywhere != 0)
        held.shafts = all_slots();
    precise dvec2 pixel = ((dvec2(at) + 0.5) * double(kLayerTile) + u_view.offset) * u_view.scale;
    if (u_view.far_share > 0.0 && held.slots != uvec2(0u)) {
        precise double nearest = from_tile(u_view.lights[0], pixel, held.slots);
        for (int i = 1; i < u_view.light_count; ++i)
            nearest = min(nearest, from_tile(u_view.lights[i], pixel, held.slots));
        precise double far_from = u_view.far_share * nearest;
        held.far_from = far_from;
    }
    if (u_view.spaced != 0 && held.slots != uvec2(0u)) {
        held.longest = double(uintBitsToFloat(~seen.not_longest));
        // Light has detail of its own beside where it comes from.
        for (int i = 0; i < u_view.light_count; ++i)
            held.longest = min(held.longest, from_ray(u_view.lights[i], pixel));
        held.longest_in_shaft = min(held.longest, u_view.shaft / double(uintBitsToFloat(seen.most)));
    }
    imageStore(u_tiles_img, at, step_tile(held));
}
