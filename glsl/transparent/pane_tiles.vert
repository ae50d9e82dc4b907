// One point a tile of the picture of which every ray, those of the march around its pixels too, meets the same panes.
//   in   a texel a tile: whether it may see a medium (pass/tiles.vert)
//   out  what its panes do together
#include "scene/frame.glsl"
#include "scene/panes.glsl"

// Variant
const int kTilePixels = 1;    // along a tile's edge
const int kPaneCount = 1;     // as many as there may be
const bool kNoMedia = false;  // those that see no medium; else the others

layout(binding = STEP_TILES_UNIT) uniform usampler2D u_tiles_tx;
flat out vec3 panes_emitted;  // without media
flat out vec3 panes_kept;
flat out vec2 panes_farthest;  // view_z [m] beyond which all are met, and which they are: a sum of powers of two

void main()
{
    ivec2 count = textureSize(u_tiles_tx, 0);
    ivec2 at = ivec2(gl_VertexID % count.x, gl_VertexID / count.x);
    bool drawn = (texelFetch(u_tiles_tx, at, 0).x == 0u) == kNoMedia;
    vec2 around = vec2(float(kLayerScale) + 0.5);
    vec2 low = vec2(at * kTilePixels) - around, high = vec2((at + 1) * kTilePixels) + around;
    panes_emitted = vec3(0.0);
    panes_kept = vec3(1.0);
    panes_farthest = vec2(0.0);
    for (int k = kPaneCount - 1; k >= 0; --k) {
        vec3 inside = vec3(0.0), below = vec3(0.0), above = vec3(0.0);
        float farthest = 0.0;
        for (int i = 0; i < 4; ++i) {
            vec2 pixel = vec2((i & 1) == 0 ? low.x : high.x, (i & 2) == 0 ? low.y : high.y);
            vec4 hit = pane_hit(k, pixel * u_frame.inverse_full_size * 2.0 - 1.0);
            PaneSides sides = pane_sides(hit, u_panes.view_z);
            inside += sides.low * (1.0 - sides.high);
            below += 1.0 - sides.low;
            above += sides.high;
            farthest = max(farthest, pane_view_z(hit));
        }
        bool is_there = k < u_panes.count && inside == vec3(4.0);
        bool is_beside = k >= u_panes.count || any(equal(max(below, above), vec3(4.0)));
        drawn = drawn && (is_there || is_beside);
        if (is_there) {
            vec3 kept = u_panes.kept[k].rgb;
            panes_emitted = panes_emitted * kept + u_panes.emitted[k].rgb;
            panes_kept *= kept;
            panes_farthest = vec2(max(panes_farthest.x, farthest), panes_farthest.y + float(1 << k));
        }
    }
    gl_PointSize = float(kTilePixels);
    drawn = drawn && panes_farthest.y > 0.0;
    const float kDone = -0.5;  // src/transparent/media_mask.h
    gl_Position = vec4(drawn ? (vec2(at) + 0.5) / vec2(count) * 2.0 - 1.0 : vec2(2.0), kDone, 1.0);
}
