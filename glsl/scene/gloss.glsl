// What the GGX layer of a glossy surface reflects (lib/ggx.glsl) of each light, gathered beside the irradiance that its
// base scatters.
#include "lib/ggx.glsl"
#include "scene/frame.glsl"

layout(binding = LTC_UNIT) uniform sampler2DArray u_ltc_tx;

struct Gloss {
    vec3 wo;  // to the eye
    float alpha;
    vec3 f0;
    vec2 ab;  // directional albedos: lib/ggx.glsl
    // Turns directions so that those of D V n.wi, over its integral, are a cosine's about z: Heitz and others 2016,
    // "Real-Time Polygonal-Light Shading with Linearly Transformed Cosines".
    mat3 cosine_from_world;
    float turned_volume;  // its determinant
};

Gloss gloss;
vec3 reflected = vec3(0.0);  // so far [W/m^2/sr]

void begin_gloss(vec3 n)
{
    gloss.wo = -normalize(camera_ray(gl_FragCoord.xy * u_frame.inverse_full_size * 2.0 - 1.0).direction);
    gloss.alpha = ggx_alpha(u_draw.roughness);
    gloss.f0 = ggx_f0(u_draw.albedo, u_draw.metallic);
    // Texels' middles are the table's ends.
    float n_wo = clamp(dot(n, gloss.wo), 0.0, 1.0);
    // The root of 1 may be a little more than 1: GLSL lets it be off by some units in the last place.
    vec2 at = vec2(sqrt(max(1.0 - sqrt(n_wo), 0.0)), u_draw.roughness);
    const vec2 kSize = vec2(LTC_COLUMNS, LTC_ROWS);
    vec2 uv = (at * (kSize - 1.0) + 0.5) / kSize;
    gloss.ab = textureLod(u_ltc_tx, vec3(uv, 1.0), 0.0).xy;
    vec4 fit = textureLod(u_ltc_tx, vec3(uv, 0.0), 0.0);
    vec3 x = gloss.wo - n * dot(n, gloss.wo);
    if (dot(x, x) < 1e-12)  // looked straight down on: the same all around
        x = abs(n.x) < 0.5 ? cross(n, vec3(1.0, 0.0, 0.0)) : cross(n, vec3(0.0, 1.0, 0.0));
    x = normalize(x);
    gloss.cosine_from_world = mat3(fit.x, 0.0, gloss.alpha * fit.z, 0.0, 1.0, 0.0, fit.y, 0.0, gloss.alpha * fit.w) *
                              transpose(mat3(x, cross(n, x), n));
    gloss.turned_volume = gloss.alpha * (fit.x * fit.w - fit.y * fit.z);
}

// Of the lobe's fit [1/sr].
float cosine_density(vec3 wi)
{
    vec3 w = gloss.cosine_from_world * wi;
    float length2 = dot(w, w);
    return max(w.z, 0.0) * gloss.turned_volume / (kPi * length2 * length2);
}

// Of one direction, in which so much irradiance arrives.
void add_reflection(vec3 irradiance, vec3 n, vec3 wi)
{
    reflected += irradiance * ggx_reflection(n, gloss.wo, wi, gloss.alpha, gloss.f0);
}

#include "scene/ambient_gloss.glsl"
