// Where slices lie along view depth, and back: z = x + (y - x) t(s), s in 0..1 through the slices.
//   range    x, y: view_z [m] of both ends; z: y - x
//   spacing  x: 0 linear, t = s
//               1 exponential, t = (exp2(y s) - 1) / (exp2(y) - 1), Eevee's of October 2017: its
//                 z = (exp2(s / d) - a) / b with a and b put in, and y = 1 / d
//               2 a power, t = s^y, after Wronski 2014
//            y: the rate or the power; z: exp2(y) - 1
float slice_view_z(float s, vec4 range, vec4 spacing)
{
    float t = s;
    if (spacing.x == 1.0)
        t = (exp2(spacing.y * s) - 1.0) / spacing.z;
    else if (spacing.x == 2.0)
        t = pow(s, spacing.y);
    return range.x + range.z * t;
}

// s of a view depth, held to 0..1.
float slice_at(float view_z, vec4 range, vec4 spacing)
{
    float t = clamp((view_z - range.x) / range.z, 0.0, 1.0);
    if (spacing.x == 1.0)
        return log2(1.0 + t * spacing.z) / spacing.y;
    if (spacing.x == 2.0)
        return pow(t, 1.0 / spacing.y);
    return t;
}

// view_z counted in slices, linear in depth within each: what is integrated along depth is linear
// there in a uniform medium, and an exponential s is not.
float slices_before(float view_z, float slices, vec4 range, vec4 spacing)
{
    float k = min(floor(slice_at(view_z, range, spacing) * slices), slices - 1.0);
    float begin = slice_view_z(k / slices, range, spacing);
    float end = slice_view_z((k + 1.0) / slices, range, spacing);
    // A slice may be thinner than a 32-bit depth tells.
    return k + clamp((view_z - begin) / max(end - begin, 1e-30), 0.0, 1.0);
}
