// The march's history by a compute shader, over listed tiles: pass/march_history.glsl.
#include "pass/march_history.glsl"
#include "pass/layer_images.glsl"
#include "pass/listed_texel.glsl"

void main()
{
    ListedTexel at = listed_texel(ivec2(u_frame.layer_size));
    if (!at.is_there)
        return;
    KeptTexel texel = gather_history(at.texel);
    store_layer(at.texel, texel.kept, texel.more);
}
