// A frame's panes in order, and where rays meet them.
#include "shared/bindings.h"
#include "shared/pane_params.h"

layout(std140, binding = PANES_BLOCK) uniform Panes { PaneParams u_panes; };

// Where a ray meets a pane's plane: x and y over w are 0..1 along its edges, z over w is view_z [m].
vec4 pane_hit(int k, vec2 ndc) { return u_panes.at[k] + ndc.x * u_panes.at_dx[k] + ndc.y * u_panes.at_dy[k]; }
float pane_view_z(vec4 hit) { return hit.z / hit.w; }

// 1 where a pane is seen before a surface, else 0. Nothing is divided: w is positive before the eye.
//   view_z  of the near plane and of the surface [m]
float pane_seen(vec4 hit, vec2 view_z)
{
    vec3 low = step(vec3(0.0), vec3(hit.xy, hit.z - view_z.x * hit.w));
    vec3 high = step(hit.www * vec3(1.0, 1.0, view_z.y), hit.xyz);
    vec3 inside = low * (1.0 - high);
    return inside.x * inside.y * inside.z;
}
