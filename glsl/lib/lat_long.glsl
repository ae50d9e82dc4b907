// Texture coordinates of a direction in a latitude-longitude map whose first row is the zenith (+z) and
// whose middle column is +x: u = 1/2 - atan(y, x) / 2 pi, v = acos(z) / pi.
vec2 lat_long_uv(vec3 d)
{
    return vec2(0.5 - atan(d.y, d.x) * 0.159154943091895, acos(clamp(d.z, -1.0, 1.0)) * 0.318309886183791);
}
