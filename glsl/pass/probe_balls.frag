// Each probe in its place: a mirror ball that shows its map and, to the right of it, a matt one that shows its harmonics.
//   in   the host's depth, what probes have seen
//   out  radiance [W/m^2/sr]; nothing where no ball is in front
#include "lib/depth.glsl"
#include "lib/phase.glsl"
#include "lib/probe_map.glsl"
#include "scene/frame.glsl"
#include "shared/inspect_params.h"

layout(std140, binding = INSPECT_BLOCK) uniform Inspect { InspectParams u_inspect; };
layout(std140, binding = PROBES_BLOCK) uniform Probes { ProbesParams u_probes; };
layout(binding = PROBES_UNIT) uniform sampler2DArray u_probes_tx;
layout(binding = SCENE_DEPTH_UNIT) uniform sampler2D u_scene_depth_tx;
layout(location = 0) out vec4 out_color;

void main()
{
    float radius = u_inspect.plane_place;
    Ray ray = camera_ray(gl_FragCoord.xy * u_frame.inverse_full_size * 2.0 - 1.0);
    float depth = texelFetch(u_scene_depth_tx, ivec2(gl_FragCoord.xy), 0).r;
    float nearest = view_z_of(depth, u_frame.view_z_from_depth, u_frame.sky_depth);
    float per_metre = length(ray.direction);
    vec3 d = ray.direction / per_metre;
    bool met = false;
    for (int i = 0; i < u_probes.count; ++i)
        for (int side = 0; side < 2; ++side) {
            vec3 center = u_probes.probes[i].position + u_inspect.plane_axis * (side == 0 ? -radius : radius);
            vec3 to = center - ray.origin;
            float b = dot(to, d);
            vec3 foot = to - b * d;
            float root = radius * radius - dot(foot, foot);
            float view_z = (b - sqrt(max(root, 0.0))) / per_metre;
            if (root < 0.0 || view_z <= 0.0 || view_z >= nearest)
                continue;
            nearest = view_z;
            met = true;
            vec3 n = (view_z * ray.direction - to) / radius;
            int layer = u_probes.probes[i].layer;
            out_color.rgb =
                side == 0 ? probe_map_at(u_probes_tx, u_probes.placed.maps[0], layer, octahedral_uv(reflect(d, n))).rgb
                          : probe_irradiance(u_probes_tx, u_probes.placed.harmonics, layer, n).rgb / kPi;
        }
    if (!met)
        discard;
    out_color.a = 1.0;
}
