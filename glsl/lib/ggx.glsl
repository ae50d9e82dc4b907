// How a glossy surface reflects: a GGX layer over a Lambertian base, from the factors of glTF 2.0's metallic-roughness
// model. n the normal, wo to the eye, wi to the light, h = normalize(wo + wi), all of unit length.
//
//   f(wo, wi) = D(n.h) V(n.wo, n.wi) F(wo.h) + base(n.wo) / pi                                           [1/sr]
//   alpha     = max(roughness^2, kMinAlpha)
//   D         = alpha^2 / (pi ((n.h)^2 (alpha^2 - 1) + 1)^2)          GGX: Walter and others 2007, equation 33
//   V         = 1/2 / (n.wi sqrt(alpha^2 + (1 - alpha^2) (n.wo)^2) + n.wo sqrt(alpha^2 + (1 - alpha^2) (n.wi)^2))
//               Smith's visibility, height-correlated, over 4 n.wo n.wi: Heitz 2014, equation 99
//   F         = f0 + (1 - f0) (1 - wo.h)^5                            Schlick 1994
//   f0        = mix(0.04, albedo, metallic)
//
// The base's share of the light depends on n.wo alone, so that it is a factor of a surface's irradiance whatever sends
// that. With the directional albedos of D V (1 - wo.h)^5, b, and of D V times the rest, a, both of n.wo and alpha:
//
//   once      = f0 a + b                                              what the layer reflects of a uniform world
//   more      = (1 - a - b) once f_avg / (1 - f_avg (1 - a - b))      what it reflects after meeting itself again:
//   f_avg     = f0 + (1 - f0) / 21                                    Fdez-Aguera 2019
//   base      = more + (1 - metallic) albedo (1 - once - more)        the Lambertian below has what the layer leaves
//
// glTF weighs the Lambertian by 1 - F(wo.h) instead, which loses the light that the layer reflects to other half
// vectors. Here a surface with nothing to absorb returns just what arrives from a uniform world, at every roughness.
// The price: D V F is the same with wo and wi exchanged, base is not.
#include "lib/phase.glsl"

// Point-like lights have no size, and the reflection of one in a mirror none either: no pixel's middle would meet it.
// With this alpha a reflected sun is about as wide as the real one (a half vector off by alpha turns wi by 2 alpha,
// 0.23 degrees). It also keeps D within what 32 bits resolve: 8e4 / sr at its peak.
const float kMinAlpha = 0.002;

// At the silhouette of smooth normals n.wo may be 0 or less; V is taken at this cosine there, which keeps it finite.
const float kMinCosine = 1e-4;

float ggx_alpha(float roughness) { return max(roughness * roughness, kMinAlpha); }

float ggx_distribution(vec3 n, vec3 h, float alpha)
{
    // 1 - (n.h)^2 cancels near the peak; the sine does not.
    vec3 sine = cross(n, h);
    float cosine = dot(n, h);
    float d = dot(sine, sine) + alpha * alpha * cosine * cosine;
    return alpha * alpha / (kPi * d * d);
}

float ggx_visibility(float n_wo, float n_wi, float alpha)
{
    float alpha2 = alpha * alpha;
    n_wo = max(n_wo, kMinCosine);
    return 0.5 /
           (n_wi * sqrt(alpha2 + (1.0 - alpha2) * n_wo * n_wo) + n_wo * sqrt(alpha2 + (1.0 - alpha2) * n_wi * n_wi));
}

vec3 schlick_fresnel(vec3 f0, float wo_h)
{
    float x = 1.0 - clamp(wo_h, 0.0, 1.0);
    float x2 = x * x;
    return f0 + (1.0 - f0) * (x2 * x2 * x);
}

vec3 ggx_f0(vec3 albedo, float metallic) { return mix(vec3(0.04), albedo, metallic); }

// D V F [1/sr]; n.wi > 0.
vec3 ggx_reflection(vec3 n, vec3 wo, vec3 wi, float alpha, vec3 f0)
{
    vec3 between = wo + wi;
    float size = length(between);
    if (size < 1e-6)  // straight from behind a smooth silhouette
        return vec3(0.0);
    vec3 h = between / size;
    return schlick_fresnel(f0, dot(wo, h)) *
           (ggx_distribution(n, h, alpha) * ggx_visibility(dot(n, wo), dot(n, wi), alpha));
}

// What the layer reflects of a uniform world without meeting itself again. ab: a and b above, at n.wo and alpha.
vec3 ggx_once(vec3 f0, vec2 ab) { return f0 * ab.x + ab.y; }

// The Lambertian part over irradiance / pi. ab: as above.
vec3 ggx_base(vec3 albedo, float metallic, vec3 f0, vec2 ab)
{
    vec3 once = ggx_once(f0, ab);
    float lost = max(1.0 - ab.x - ab.y, 0.0);  // a mirror loses none, to what rounding leaves
    vec3 f_avg = f0 + (1.0 - f0) / 21.0;
    vec3 more = lost * once * f_avg / (1.0 - f_avg * lost);
    return more + (1.0 - metallic) * albedo * (1.0 - once - more);
}
