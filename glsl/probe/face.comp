// A picture that was drawn for a probe to a face of its cube.
//   out  radiance; alpha: 1 where a surface is, 0 where the sky is
#include "shared/bindings.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = PROBE_SOURCE_UNIT) uniform sampler2D u_color_tx;
layout(binding = PROBE_DEPTH_UNIT) uniform sampler2D u_depth_tx;
layout(rgba32f, binding = 0) writeonly uniform image2D u_face_img;

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(u_face_img))))
        return;
    vec3 radiance = texelFetch(u_color_tx, pixel, 0).rgb;
    // What is not a number would spread to all of a probe.
    radiance = mix(vec3(0.0), min(radiance, 1e30), greaterThanEqual(radiance, vec3(0.0)));
    imageStore(u_face_img, pixel, vec4(radiance, texelFetch(u_depth_tx, pixel, 0).r > 0.0 ? 1.0 : 0.0));
}
