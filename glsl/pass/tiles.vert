// One point a tile: a square of pixels, drawn where there is something to draw.
//   in   a texel a tile, as src/pass/step_tiles.cpp sets them
//   out  tile  x, y: view_z [m] between which its rays may meet a medium; z: splits of the step lattice that
//              one step takes
//   TILE_PIXELS  along its edge
#include "shared/bindings.h"

layout(binding = STEP_TILES_UNIT) uniform sampler2D u_tiles_tx;
flat out vec3 tile;

void main()
{
    ivec2 count = textureSize(u_tiles_tx, 0);
    ivec2 at = ivec2(gl_VertexID % count.x, gl_VertexID / count.x);
    vec4 texel = texelFetch(u_tiles_tx, at, 0);
    tile = texel.xyz;
    gl_PointSize = float(TILE_PIXELS);
    gl_Position = vec4(texel.w > 0.0 ? (vec2(at) + 0.5) / vec2(count) * 2.0 - 1.0 : vec2(2.0), 0.0, 1.0);
}
