// The upsample by a compute shader, over listed tiles: resolve/upsample.glsl.
#include "resolve/upsample.glsl"
#include "resolve/picture_image.glsl"
#include "pass/listed_texel.glsl"

void main()
{
    ListedTexel at = listed_texel(ivec2(u_frame.full_size));
    if (at.is_there)
        lay_over_picture(at.texel, upsampled(at.texel));
}
