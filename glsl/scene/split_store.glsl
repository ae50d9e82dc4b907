// Where a march keeps what it has met: before the frame's depths, or before its panes.
#include "scene/panes.glsl"
#include "scene/split_depths.glsl"

// Variant: panes in order, as many as there may be; 0: it is the frame's depths
const int kPanes = 0;

layout(binding = SPLIT_SCATTERING_IMAGE) writeonly uniform image2DArray u_split_scattering_img;
layout(binding = SPLIT_TRANSMITTANCE_IMAGE) writeonly uniform image2DArray u_split_transmittance_img;

const float kNoSplit = 3e38;  // [m]: none is left

// The depths of a ray [m], and the next at which it is kept. Planes of panes may cross where the panes do not, so they
// are in no order that all rays share.
struct SplitWalk {
    int next;
    float view_z;
    float panes[kPanes > 0 ? kPanes : 1];
};

void step_on(inout SplitWalk walk)
{
    if (kPanes == 0) {
        ++walk.next;
        walk.view_z = walk.next < u_splits.count ? split_view_z(walk.next) : kNoSplit;
        return;
    }
    int next = kPanes;
    float nearest = kNoSplit;
    for (int k = 0; k < kPanes; ++k) {
        float view_z = walk.panes[k];
        bool is_later = view_z > walk.view_z || (view_z == walk.view_z && k > walk.next);
        if (is_later && view_z < nearest) {
            nearest = view_z;
            next = k;
        }
    }
    walk.next = next;
    walk.view_z = nearest;
}

SplitWalk split_walk(vec2 ndc, bool keeps)
{
    const float kFarthest = 1e37;
    SplitWalk walk;
    walk.next = -1;
    walk.view_z = keeps ? -1.0 : kNoSplit;
    for (int k = 0; k < kPanes; ++k) {
        float view_z = pane_view_z(pane_hit(k, ndc));
        walk.panes[k] = k >= u_panes.count ? kNoSplit : view_z >= 0.0 ? min(view_z, kFarthest) : kFarthest;
    }
    if (keeps)
        step_on(walk);
    return walk;
}
