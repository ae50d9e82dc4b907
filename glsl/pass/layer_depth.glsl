// The scene's depth at the volume layer's resolution.
//   in   the host's depth, one texel a pixel
//   out  view_z [m] of the kLayerScale^2 pixels that a texel stands for: of their middle or of one of them
#include "lib/depth.glsl"
#include "scene/frame.glsl"

// Variant: where they are of one plane, take its depth amid them, where the texel's ray goes, so that it ends on the
// plane and not beyond it. Else take the nearest and the farthest in turns, so that both sides of an edge are there for
// the upsample to find. Without it, the lower left one, as 2017 did.
const bool kCheckerboard = false;

layout(binding = SCENE_DEPTH_UNIT) uniform sampler2D u_scene_depth_tx;

float scene_view_z(ivec2 pixel)
{
    ivec2 last = ivec2(u_frame.full_size) - 1;  // an odd size ends in half a texel
    return view_z_of(texelFetch(u_scene_depth_tx, clamp(pixel, ivec2(0), last), 0).r, u_frame.view_z_from_depth,
                     u_frame.sky_depth);
}

// How far 1 / view_z is from growing evenly along one of a block's diagonals, which goes on to the pixels next to the
// block where that has two: a step amid two could be a plane as well.
float bend_along(ivec2 first, ivec2 way)
{
    vec4 z = vec4(scene_view_z(first), scene_view_z(first + way), scene_view_z(first + 2 * way),
                  scene_view_z(first + 3 * way));
    vec4 inverse = 1.0 / z;
    vec2 bend = inverse.xy - 2.0 * inverse.yz + inverse.zw;
    return max(abs(bend.x), abs(bend.y));
}

float layer_view_z(ivec2 texel)
{
    ivec2 corner = texel * kLayerScale + ivec2(u_frame.layer_offset_pixels);
    if (!kCheckerboard || kLayerScale == 1)
        return scene_view_z(corner);
    const int kPixels = kLayerScale * kLayerScale;
    bool nearest = ((texel.x + texel.y) & 1) == 0;
    float view_z = nearest ? 1e38 : -1e38;
    // 1 / view_z is linear in a plane's picture: of two pixels as far from the middle as each other the sum is the same.
    float least = 1e38;
    float most = 0.0;
    for (int i = 0; i < kPixels / 2; ++i) {
        float a = scene_view_z(corner + ivec2(i % kLayerScale, i / kLayerScale));
        int j = kPixels - 1 - i;
        float b = scene_view_z(corner + ivec2(j % kLayerScale, j / kLayerScale));
        view_z = nearest ? min(view_z, min(a, b)) : max(view_z, max(a, b));
        float sum = 1.0 / a + 1.0 / b;
        least = min(least, sum);
        most = max(most, sum);
    }
    ivec2 start = corner + (kLayerScale == 2 ? -1 : 0);
    float bend = max(most - least, max(bend_along(start, ivec2(1)), bend_along(start + ivec2(3, 0), ivec2(-1, 1))));
    const float kBent = 0.01;
    return bend < kBent * most ? 4.0 / (least + most) : view_z;
}
