// What the GGX layer of a glossy surface reflects of light from all around: of the world, and of what probes have seen.
#include "scene/probes.glsl"

// A lobe that is seen at a slant is narrower across the plane of incidence than along it, and leans away from the mirror's
// direction: this many narrower round ones along it stand for it.
const int kLobes = 4;

// light [W/m^2/sr] about d, of GGX's alpha. irradiance: of the world as far as it arrives, and of media; open: of the world
// if nothing hid or dimmed it. So much less of it is seen in the surface; what media send is taken to be even. probes: those
// that have a share.
vec3 light_around(vec3 p, vec3 d, float alpha, vec3 irradiance, vec3 open, uint probes)
{
    vec3 light = irradiance / kPi;
    if (kEnvironment) {
        vec3 seen = min(irradiance / max(open, 1e-20), 1.0);
        light = seen * world_reflection(d, alpha) + (irradiance - seen * open) / kPi;
    }
    if (kProbes)
        light = probes_reflection(p, d, alpha, light, probes);
    return light;
}

void add_world_reflection(vec3 p, vec3 n, vec3 irradiance, vec3 open)
{
    const float kOneLobe = 0.01;   // alpha of mirrors, all but
    const float kNarrowest = 0.2;  // of a lobe, over alpha
    // Where they lie, in GGX's slopes over alpha, away from the eye and towards it, and how wide a lobe each stands for:
    // polynomials of the roughness, fitted to the light of lamps all around by scripts/fit_probe_lobes.py.
    const vec4 kSlopes[3] = vec4[3](vec4(-1.5567, 0.0581, -0.6070, 1.6021), vec4(1.7452, -0.5586, 2.9181, -0.4813),
                                    vec4(-0.0859, 0.8849, -1.6474, 0.0219));
    const vec4 kWidths[3] = vec4[3](vec4(1.0693, 1.6638, 0.0451, 1.4278), vec4(0.5580, -3.6862, 1.6229, 1.2999),
                                    vec4(-0.5322, 3.5409, -0.1982, -0.2568));
    float roughness = sqrt(gloss.alpha);
    vec4 slopes = kSlopes[0] + roughness * (kSlopes[1] + roughness * kSlopes[2]);
    vec4 widths = kWidths[0] + roughness * (kWidths[1] + roughness * kWidths[2]);
    float n_wo = max(dot(n, gloss.wo), 0.0);
    vec3 along = gloss.wo - n * n_wo;  // as long as the sine: none, and the lobe is round
    uint probes = kProbes ? probes_at(p) : 0u;
    vec3 sum = vec3(0.0), weights = vec3(0.0);
    for (int i = 0; i < kLobes && gloss.alpha > kOneLobe; ++i) {
        vec3 h = normalize(n + along * (gloss.alpha * slopes[i]));
        float wo_h = dot(gloss.wo, h);
        vec3 d = 2.0 * wo_h * h - gloss.wo;
        float n_wi = dot(n, d);
        if (wo_h <= 0.0 || n_wi <= 0.0)
            continue;
        vec3 weight =
            schlick_fresnel(gloss.f0, wo_h) * (ggx_visibility(n_wo, n_wi, gloss.alpha) * n_wi * wo_h / dot(n, h));
        sum += weight * light_around(p, d, gloss.alpha * max(widths[i] * wo_h, kNarrowest), irradiance, open, probes);
        weights += weight;
    }
    vec3 light = weights.g > 0.0 ? sum / max(weights, 1e-20)
                                 : light_around(p, reflect(-gloss.wo, n), gloss.alpha, irradiance, open, probes);
    reflected += ggx_once(gloss.f0, gloss.ab) * light;
}
