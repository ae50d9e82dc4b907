// An inspection: what a probe has seen, all around in a map of latitude and longitude, and under it by roughness; beside it
// the light that its harmonics throw on a white matt ball, seen along +y.
//   in   the probes' maps
//   out  radiance [W/m^2/sr]
#include "lib/phase.glsl"
#include "lib/probe_map.glsl"
#include "scene/frame.glsl"
#include "shared/inspect_params.h"

layout(std140, binding = INSPECT_BLOCK) uniform Inspect { InspectParams u_inspect; };
layout(std140, binding = PROBES_BLOCK) uniform Probes { ProbesParams u_probes; };
layout(binding = PROBES_UNIT) uniform sampler2DArray u_probes_tx;
layout(location = 0) out vec4 out_color;

vec3 map_at(vec2 uv, float level)
{
    float phi = (0.5 - uv.x) * 2.0 * kPi, theta = uv.y * kPi;
    vec3 d = vec3(sin(theta) * vec2(cos(phi), sin(phi)), cos(theta));
    return probe_map_at(u_probes_tx, u_probes.placed.maps[int(level)], u_inspect.slice, octahedral_uv(d)).rgb;
}

void main()
{
    const float kMap = 2.0 / 3.0;  // of the picture's width
    const float kGap = 0.02;
    vec2 size = 1.0 / u_frame.inverse_full_size;
    // From the top left, in picture widths; the map is in the middle of the height.
    vec2 at = vec2(gl_FragCoord.x, size.y - gl_FragCoord.y) / size.x;
    float levels = u_probes.placed.last;
    float small = kMap / max(levels, 1.0);
    float height = 0.5 * kMap + kGap + 0.5 * small;
    at.y -= 0.5 * (size.y / size.x - height);
    out_color = vec4(vec3(0.0), 1.0);
    vec2 uv = at / vec2(kMap, 0.5 * kMap);
    if (all(greaterThanEqual(uv, vec2(0.0))) && all(lessThan(uv, vec2(1.0))))
        out_color.rgb = map_at(uv, 0.0);
    vec2 below = vec2(at.x, at.y - 0.5 * kMap - kGap) / vec2(small, 0.5 * small);
    if (below.x >= 0.0 && below.x < levels && below.y >= 0.0 && below.y < 1.0)
        out_color.rgb = map_at(vec2(fract(below.x), below.y), 1.0 + floor(below.x));
    vec2 ball = (at - vec2(0.5 + 0.5 * kMap, 0.25 * kMap)) / (0.5 * (1.0 - kMap) - kGap);
    float r2 = dot(ball, ball);
    if (r2 < 1.0) {
        vec3 n = vec3(ball.x, -sqrt(1.0 - r2), -ball.y);
        out_color.rgb = probe_irradiance(u_probes_tx, u_probes.placed.harmonics, u_inspect.slice, n).rgb / kPi;
    }
}
