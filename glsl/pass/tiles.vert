// One point a tile: a square of pixels, drawn where there is something to draw.
//   in   a texel a tile, as src/pass/step_tiles.cpp sets them
//   out  tile  x: slots of the step lattice that hold something, as bits; y: first step of slot 0; z: steps of
//              a slot; w: splits before which four (low 16 bits), and two (high), are one step
//   TILE_PIXELS  along its edge
#include "shared/bindings.h"

layout(binding = STEP_TILES_UNIT) uniform usampler2D u_tiles_tx;
flat out uvec4 tile;

void main()
{
    ivec2 count = textureSize(u_tiles_tx, 0);
    ivec2 at = ivec2(gl_VertexID % count.x, gl_VertexID / count.x);
    tile = texelFetch(u_tiles_tx, at, 0);
    gl_PointSize = float(TILE_PIXELS);
    gl_Position = vec4(tile.x != 0u ? (vec2(at) + 0.5) / vec2(count) * 2.0 - 1.0 : vec2(2.0), 0.0, 1.0);
}
