// One point a tile: a square of pixels, drawn where there is something to draw.
//   in   a texel a tile, as StepSlots::tile() of src/pass/step_slots.h makes it
//   out  tile  the same, shared/step_tile.h
#include "shared/bindings.h"
#include "shared/step_tile.h"

// Variant
const int kTilePixels = 1;    // along a tile's edge
const bool kAllTiles = true;  // or else:
const bool kLitTiles = true;  // only those that no surface shades; or only the others
const bool kByDistance = false;
const bool kFarTiles = false;  // kByDistance: only those that lights are far from; or only the others

layout(binding = STEP_TILES_UNIT) uniform usampler2D u_tiles_tx;
flat out uvec4 tile;

// Variant. FRAME_VARYINGS: what resolve/upsample.frag asks of the frame goes with a tile.
#ifdef FRAME_VARYINGS
#include "scene/frame.glsl"
#define FRAME_VARYING out
#include "scene/frame_varying.glsl"
void take_frame()
{
    frame_depths = u_frame.view_z_from_depth;
    frame_limits = vec4(u_frame.media_range, u_frame.sky_depth, u_frame.depth_threshold);
    frame_layer = vec3(u_frame.layer_offset, u_frame.media_depth);
}
#else
void take_frame() {}
#endif

void main()
{
    ivec2 count = textureSize(u_tiles_tx, 0);
    ivec2 at = ivec2(gl_VertexID % count.x, gl_VertexID / count.x);
    tile = texelFetch(u_tiles_tx, at, 0);
    bool drawn = tile.x != 0u;
    if (!kAllTiles)
        drawn = drawn && tile_is_lit(tile.w) == kLitTiles;
    if (kByDistance)
        drawn = drawn && tile_is_far(tile.w) == kFarTiles;
    take_frame();
    gl_PointSize = float(kTilePixels);
    gl_Position = vec4(drawn ? (vec2(at) + 0.5) / vec2(count) * 2.0 - 1.0 : vec2(2.0), 0.0, 1.0);
}
