// A frame's panes in order, and where rays meet them.
#include "shared/bindings.h"
#include "shared/pane_params.h"

layout(std140, binding = PANES_BLOCK) uniform Panes { PaneParams u_panes; };

// Where a ray meets a pane's plane: x and y over w are 0..1 along its edges, z over w is view_z [m].
vec4 pane_hit(int k, vec2 ndc) { return u_panes.at[k] + ndc.x * u_panes.at_dx[k] + ndc.y * u_panes.at_dy[k]; }
float pane_view_z(vec4 hit) { return hit.z / hit.w; }

// Of a pane's edges and of depth: 1 where a ray meets it beyond the low end, and beyond the high one; else 0. Nothing is
// divided: w is positive before the eye.
struct PaneSides {
    vec3 low, high;
};

//   view_z  of the near plane and of the surface [m]
PaneSides pane_sides(vec4 hit, vec2 view_z)
{
    return PaneSides(step(vec3(0.0), vec3(hit.xy, hit.z - view_z.x * hit.w)),
                     step(hit.www * vec3(1.0, 1.0, view_z.y), hit.xyz));
}

// 1 where a pane is seen before a surface, else 0.
float pane_seen(vec4 hit, vec2 view_z)
{
    PaneSides sides = pane_sides(hit, view_z);
    vec3 inside = sides.low * (1.0 - sides.high);
    return inside.x * inside.y * inside.z;
}
