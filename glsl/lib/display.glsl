// Linear light to a screen's encoded values: what src/write/display_transform.cpp does, which names
// its sources.

float hable(float x)
{
    return (x * (0.15 * x + 0.05) + 0.004) / (x * (0.15 * x + 0.5) + 0.06) - 0.02 / 0.3;
}

float filmic_curve(float radiance)
{
    const float white = 8.0;
    const float scale = 3.4583109;
    float black = hable(0.0);
    float mapped = (hable(scale * min(radiance, white)) - black) / (hable(scale * white) - black);
    return clamp(mapped, 0.0, 1.0);
}

vec3 filmic(vec3 radiance)
{
    float peak = max(radiance.r, max(radiance.g, radiance.b));
    float mapped_peak = filmic_curve(peak);
    float to_white = 1.0 - 1.0 / (0.15 * max(0.0, peak - mapped_peak) + 1.0);
    vec3 mapped = vec3(filmic_curve(radiance.r), filmic_curve(radiance.g), filmic_curve(radiance.b));
    return mix(mapped, vec3(mapped_peak), to_white);
}

vec3 srgb_encode(vec3 linear)
{
    vec3 x = clamp(linear, 0.0, 1.0);
    return mix(1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, 12.92 * x, lessThanEqual(x, vec3(0.0031308)));
}
