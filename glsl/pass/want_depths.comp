// Which texels of the layer's depth the picture's tiles ask for. As want_depths() of src/pass/step_tiles.cpp.
//   in   tiles of the picture; tiles of the depth with nothing in them
//   out  those that are asked for
#include "pass/step_view.glsl"

layout(local_size_x = PICTURE_GROUP, local_size_y = PICTURE_GROUP) in;
layout(binding = STEP_TILES_UNIT) uniform usampler2D u_picture_tiles_tx;
layout(binding = STEP_TILES_IMAGE, rgba32ui) writeonly uniform uimage2D u_depth_tiles_img;

void main()
{
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, u_view.picture_tiles)) || texelFetch(u_picture_tiles_tx, at, 0).x == 0u)
        return;
    dvec2 low = dvec2(at) * double(kPictureTile) / u_view.scale - u_view.offset;
    ivec4 asked =
        tiles_between(low - u_view.reach - 1.0, low + double(kPictureTile) / u_view.scale + u_view.reach + 1.0,
                      double(kLayerTile), u_view.march_tiles);
    for (int y = asked.y; y <= asked.w; ++y)
        for (int x = asked.x; x <= asked.z; ++x)
            imageStore(u_depth_tiles_img, ivec2(x, y), uvec4(1u, 0u, 0u, 0u));
}
