// The scene's depth at the volume layer's resolution.
//   in   the host's depth, one texel a pixel
//   out  view_z [m] of one of the kLayerScale^2 pixels that a texel stands for
#include "lib/depth.glsl"
#include "scene/frame.glsl"

// Variant: take the nearest and the farthest in turns, so that both sides of an edge are there for the upsample to
// find; else the lower left one, as 2017 did.
const bool kCheckerboard = false;

layout(binding = SCENE_DEPTH_UNIT) uniform sampler2D u_scene_depth_tx;
layout(location = 0) out float out_view_z;

float scene_view_z(ivec2 pixel)
{
    ivec2 last = ivec2(u_frame.full_size) - 1;  // an odd size ends in half a texel
    return view_z_of(texelFetch(u_scene_depth_tx, clamp(pixel, ivec2(0), last), 0).r, u_frame.view_z_from_depth,
                     u_frame.sky_depth);
}

void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    ivec2 corner = texel * kLayerScale + ivec2(u_frame.layer_offset_pixels);
    float view_z = scene_view_z(corner);
    bool nearest = ((texel.x + texel.y) & 1) == 0;
    for (int i = 1; kCheckerboard && i < kLayerScale * kLayerScale; ++i) {
        float other = scene_view_z(corner + ivec2(i % kLayerScale, i / kLayerScale));
        view_z = nearest ? min(view_z, other) : max(view_z, other);
    }
    out_view_z = view_z;
}
