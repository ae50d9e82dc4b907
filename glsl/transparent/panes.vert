// A triangle over all of a picture, or of the march's layer, with what its panes are there. All of it is affine in the
// picture, and llvmpipe interpolates it in a fraction of the time that it takes to load the block at each pixel.
#include "scene/frame.glsl"
#include "scene/panes.glsl"

// Variant
const int kPaneCount = 1;  // as many as there may be
const bool kOfLayer = false;

noperspective out vec4 pane_hits[kPaneCount];  // pane_hit()
flat out vec3 pane_kept[kPaneCount];

void main()
{
    vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
    vec2 ndc = corner;
    if (kOfLayer) {
        vec2 texel = (corner * 0.5 + 0.5) * u_frame.layer_size;
        ndc = (texel + u_frame.layer_offset) * float(kLayerScale) * u_frame.inverse_full_size * 2.0 - 1.0;
    }
    for (int k = 0; k < kPaneCount; ++k) {
        pane_hits[k] = k < u_panes.count ? pane_hit(k, ndc) : vec4(-1.0);
        pane_kept[k] = u_panes.kept[k].rgb;
    }
    gl_Position = vec4(corner, 0.0, 1.0);
}
