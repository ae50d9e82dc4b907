// A layer's targets as images: the first, and the second where the variant has one.
#include "shared/bindings.h"

// Variant
const bool kOneTarget = false;

layout(binding = LAYER_IMAGE) writeonly uniform image2D u_layer_img;
layout(binding = LAYER_MORE_IMAGE) writeonly uniform image2D u_layer_more_img;

void store_layer(ivec2 texel, vec4 first, vec4 second)
{
    imageStore(u_layer_img, texel, first);
    if (!kOneTarget)
        imageStore(u_layer_more_img, texel, second);
}
