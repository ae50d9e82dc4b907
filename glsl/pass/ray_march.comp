// The ray march by a compute shader, over listed tiles: pass/ray_march.glsl.
#include "pass/layer_images.glsl"
#include "pass/listed_texel.glsl"
#include "pass/ray_march.glsl"

layout(binding = STEP_TILES_UNIT) uniform usampler2D u_tiles_tx;

void main()
{
    ListedTexel at = listed_texel(ivec2(u_frame.layer_size));
    if (!at.is_there)
        return;
    Marched marched = march_texel(at.texel, texelFetch(u_tiles_tx, at.tile, 0));
    store_layer(at.texel, marched.scattering, marched.transmittance);
}
