// A volume smoothed by the cubic B-spline of its texels, in 8 trilinear fetches instead of 64: pairs of
// texels are fetched as one, at the place between them that gives their two weights. Ruijters, ter Haar
// Romeny and Suetens 2008, "Efficient GPU-Based Texture Interpolation using Uniform B-Splines".
//   uvw  0..1

// Along one axis of n texels: where the two fetches are, in 0..1, and the weight of the second.
void bspline_pairs(float u, float n, out vec2 place, out float second)
{
    float x = u * n - 0.5;
    float i = floor(x);
    float f = x - i;
    float f2 = f * f;
    float f3 = f2 * f;
    float w1 = (4.0 - 6.0 * f2 + 3.0 * f3) / 6.0;
    float w3 = f3 / 6.0;
    float w0 = (1.0 - f) * (1.0 - f) * (1.0 - f) / 6.0;
    second = 1.0 - (w0 + w1);
    place = (i + vec2(w1 / (w0 + w1) - 0.5, w3 / second + 1.5)) / n;
}

vec4 texture_tricubic(sampler3D volume, vec3 uvw)
{
    vec3 n = vec3(textureSize(volume, 0));
    vec2 x, y, z;
    vec3 second;
    bspline_pairs(uvw.x, n.x, x, second.x);
    bspline_pairs(uvw.y, n.y, y, second.y);
    bspline_pairs(uvw.z, n.z, z, second.z);
    vec4 row[4];
    for (int i = 0; i < 4; ++i) {
        vec2 yz = vec2((i & 1) == 0 ? y.x : y.y, i < 2 ? z.x : z.y);
        row[i] = mix(textureLod(volume, vec3(x.x, yz), 0.0), textureLod(volume, vec3(x.y, yz), 0.0), second.x);
    }
    return mix(mix(row[0], row[1], second.y), mix(row[2], row[3], second.y), second.z);
}
