// A triangle over all of a picture, with what its panes are there. All of it is affine in the picture, and llvmpipe
// interpolates it in a fraction of the time that it takes to load the block at each pixel.
#include "scene/panes.glsl"

// Variant
const int kPaneCount = 1;  // as many as there may be

noperspective out vec4 pane_hits[kPaneCount];  // pane_hit()

void main()
{
    vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
    for (int k = 0; k < kPaneCount; ++k)
        pane_hits[k] = k < u_panes.count ? pane_hit(k, corner) : vec4(-1.0);
    gl_Position = vec4(corner, 0.0, 1.0);
}
