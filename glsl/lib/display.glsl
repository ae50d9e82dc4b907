// Linear light to a screen's encoded values: what src/write/display_transform.cpp does, which names
// its sources.
#include "shared/filmic.h"

float hable(float x)
{
    return (x * (HABLE_A * x + HABLE_C * HABLE_B) + HABLE_D * HABLE_E) /
               (x * (HABLE_A * x + HABLE_B) + HABLE_D * HABLE_F) -
           HABLE_E / HABLE_F;
}

float filmic_curve(float radiance)
{
    float black = hable(0.0);
    float white = hable(FILMIC_SCALE * FILMIC_WHITE) - black;
    float mapped = (hable(FILMIC_SCALE * min(radiance, FILMIC_WHITE)) - black) / white;
    return clamp(mapped, 0.0, 1.0);
}

vec3 filmic(vec3 radiance)
{
    float peak = max(radiance.r, max(radiance.g, radiance.b));
    float mapped_peak = filmic_curve(peak);
    float to_white = 1.0 - 1.0 / (FILMIC_DESATURATION * max(0.0, peak - mapped_peak) + 1.0);
    vec3 mapped = vec3(filmic_curve(radiance.r), filmic_curve(radiance.g), filmic_curve(radiance.b));
    return mix(mapped, vec3(mapped_peak), to_white);
}

vec3 srgb_encode(vec3 linear)
{
    vec3 x = clamp(linear, 0.0, 1.0);
    return mix(1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, 12.92 * x, lessThanEqual(x, vec3(0.0031308)));
}
