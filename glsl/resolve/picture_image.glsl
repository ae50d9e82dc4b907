// A resolve by a compute shader: it blends with the picture itself, as the blending stage would.
//   in, out  the picture, whose alpha stays
#include "shared/bindings.h"

// Variant, and PICTURE_FORMAT, the picture's as a layout qualifier names it: resolve::LayerBlend
const bool kAdds = true;  // what is resolved is added to the picture times a factor:
const int kFactor = FACTOR_ONE;
const bool kNormalized = false;  // the format holds 0..1: what is blended is clamped to that, as OpenGL has it

layout(binding = PICTURE_IMAGE, PICTURE_FORMAT) uniform image2D u_picture_img;

void lay_over_picture(ivec2 pixel, Resolved resolved)
{
    if (kNormalized) {
        resolved.color = clamp(resolved.color, 0.0, 1.0);
        resolved.transmittance = clamp(resolved.transmittance, 0.0, 1.0);
    }
    vec4 behind = imageLoad(u_picture_img, pixel);
    vec3 laid = kAdds ? resolved.color.rgb : vec3(0.0);
    if (kFactor == FACTOR_ONE)
        laid += behind.rgb;
    else if (kFactor == FACTOR_ALPHA)
        laid += behind.rgb * resolved.color.a;
    else if (kFactor == FACTOR_COLOR)
        laid += behind.rgb * resolved.color.rgb;
    else if (kFactor == FACTOR_TRANSMITTANCE)
        laid += behind.rgb * resolved.transmittance;
    imageStore(u_picture_img, pixel, vec4(laid, behind.a));
}
