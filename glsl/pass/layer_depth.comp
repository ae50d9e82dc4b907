// The layer's depth by a compute shader, over listed tiles: pass/layer_depth.glsl.
#include "pass/layer_depth.glsl"
#include "pass/listed_texel.glsl"

layout(binding = LAYER_IMAGE) writeonly uniform image2D u_view_z_img;

void main()
{
    ListedTexel at = listed_texel(ivec2(u_frame.layer_size));
    if (at.is_there)
        imageStore(u_view_z_img, at.texel, vec4(layer_view_z(at.texel)));
}
