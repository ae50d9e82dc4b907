// A transparent that casts, in a layer of the map of what lights are filtered by: the nearest one of those behind the
// layer before, by the depth test; or in the last layer all of them, by blending, which multiplies colours and keeps the
// least depth.
//   out  rgb: what it lets through; alpha: its depth in the light's view, 0..1
#include "lib/blend.glsl"
#include "lib/shadow.glsl"
#include "lib/transparent_source.glsl"
#include "shared/bindings.h"
#include "shared/light_filter_params.h"

// Variant
const bool kImage = false;   // its colour and alpha are a picture's
const bool kBehind = false;  // there is a layer before

layout(std140, binding = DRAW_BLOCK) uniform Draw { LightFilterDrawParams u_draw; };
layout(binding = TRANSPARENT_IMAGE_UNIT) uniform sampler2D u_image_tx;
layout(binding = LIGHT_FILTERS_UNIT) uniform sampler2DArray u_before_tx;

in vec3 p_light;
in vec2 uv;
layout(location = 0) out vec4 out_filter;

void main()
{
    float depth = shadow_depth(u_draw.depth, p_light);
    if (kBehind && depth <= texelFetch(u_before_tx, ivec3(gl_FragCoord.xy, u_draw.layer_before), 0).a)
        discard;
    vec4 source = u_draw.source;
    if (kImage)
        source = image_source(textureLod(u_image_tx, uv, 0.0), source, u_draw.is_filter != 0u);
    out_filter = vec4(blend_factor(u_draw.factor, source, vec4(0.0)).rgb, depth);
    gl_FragDepth = depth;
}
