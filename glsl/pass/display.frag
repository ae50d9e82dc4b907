// Pictures in a window: one, or two beside a line, or how far one is from the other.
//   in   A, and of kSplit and kDifference B: linear radiance; alpha 0 where B is not there yet
//   out  encoded for a screen
#include "lib/display.glsl"
#include "shared/bindings.h"
#include "shared/display_params.h"
#include "lib/false_color.glsl"

// Variant
const bool kSplit = false;       // B begins at the wipe
const bool kDifference = false;  // in false colours

layout(std140, binding = FRAME_BLOCK) uniform Display { DisplayParams u_display; };
layout(binding = DISPLAY_A_UNIT) uniform sampler2D u_a_tx;
layout(binding = DISPLAY_B_UNIT) uniform sampler2D u_b_tx;
layout(location = 0) out vec4 out_color;

// What stands where nothing is known yet.
vec3 unknown(vec2 pixel)
{
    ivec2 cell = ivec2(pixel) / 8;
    return vec3((cell.x + cell.y) % 2 == 0 ? 0.16 : 0.2);
}

vec3 shown(vec4 radiance, ToneParams tone, vec2 pixel)
{
    if (radiance.a == 0.0)
        return unknown(pixel);
    vec3 exposed = max(vec3(0.0), radiance.rgb * tone.exposure);
    return srgb_encode(tone.filmic > 0.5 ? filmic(exposed) : exposed);
}

void main()
{
    vec2 pixel = gl_FragCoord.xy - u_display.lower_left;
    vec2 uv = pixel / u_display.size;
    vec4 a = texture(u_a_tx, uv);
    vec3 color = shown(a, u_display.tone_a, pixel);
    if (kSplit && pixel.x >= u_display.wipe)
        color = shown(texture(u_b_tx, uv), u_display.tone_b, pixel);
    if (kSplit && abs(pixel.x - u_display.wipe) < 1.0)
        color = vec3(0.9);
    if (kDifference) {
        vec4 b = texture(u_b_tx, uv);
        vec3 error = (a.rgb - b.rgb) * inversesqrt(b.rgb * b.rgb + u_display.tenth_mean_square);
        float t = sqrt(dot(error, error) / 3.0) / u_display.largest_difference;
        color = a.a == 0.0 || b.a == 0.0 ? unknown(pixel) : srgb_encode(magma(t));
    }
    out_color = vec4(color, 1.0);
}
