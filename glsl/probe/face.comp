// A picture that was drawn for a probe to a face of its cube.
//   out  radiance
#include "shared/bindings.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = PROBE_SOURCE_UNIT) uniform sampler2D u_color_tx;
layout(rgba32f, binding = 0) writeonly uniform image2D u_face_img;

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(u_face_img))))
        return;
    // Sums over a whole map would be infinite.
    imageStore(u_face_img, pixel, vec4(min(texelFetch(u_color_tx, pixel, 0).rgb, 1e30), 1.0));
}
