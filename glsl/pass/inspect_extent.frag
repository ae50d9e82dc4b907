// The least and the largest of the values in each of EXTENT_TILES^2 tiles of a picture.
//   in   values, kNothing where there are none
//   out  x: least, y: largest; a tile of nothing has the least above the largest
#include "lib/false_color.glsl"
#include "shared/bindings.h"

layout(binding = INSPECTED_UNIT) uniform sampler2D u_values_tx;
layout(location = 0) out vec4 out_extent;

void main()
{
    ivec2 size = textureSize(u_values_tx, 0);
    ivec2 tile = ivec2(gl_FragCoord.xy);
    ivec2 begin = tile * size / EXTENT_TILES;
    ivec2 end = (tile + 1) * size / EXTENT_TILES;
    vec2 extent = vec2(kNothing, -kNothing);
    for (int y = begin.y; y < end.y; ++y)
        for (int x = begin.x; x < end.x; ++x) {
            float value = texelFetch(u_values_tx, ivec2(x, y), 0).r;
            if (value < kNothing)
                extent = vec2(min(extent.x, value), max(extent.y, value));
        }
    out_extent = vec4(extent, 0.0, 0.0);
}
