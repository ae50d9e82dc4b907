// The lookup of froxels by a compute shader: resolve/froxels.glsl.
#include "resolve/froxels.glsl"
#include "resolve/picture_image.glsl"

layout(local_size_x = PICTURE_GROUP, local_size_y = PICTURE_GROUP) in;

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (all(lessThan(pixel, ivec2(u_frame.full_size))))
        lay_over_picture(pixel, resolve_pixel(pixel));
}
