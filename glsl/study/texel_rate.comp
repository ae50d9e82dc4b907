// The rate of fetches by a compute shader: study/texel_rate.glsl.
#include "shared/bindings.h"
#include "study/texel_rate.glsl"

layout(local_size_x = PICTURE_GROUP, local_size_y = PICTURE_GROUP) in;
layout(binding = LAYER_IMAGE) writeonly uniform image2D u_sum_img;

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    imageStore(u_sum_img, pixel, vec4(sum_of_fetches(pixel)));
}
