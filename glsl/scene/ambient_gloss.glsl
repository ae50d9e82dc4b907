// What the GGX layer of a glossy surface reflects of light from all around: of the world, and of what probes have seen.
#include "scene/probes.glsl"

// A lobe that is seen at a slant is narrower across the plane of incidence than along it, and leans away from the mirror's
// direction: this many narrower round ones along it stand for it.
const int kLobes = 4;

// light [W/m^2/sr] about d, of GGX's alpha. irradiance: of the world as far as it arrives, and of media; open: of the world
// if nothing hid or dimmed it. So much less of it is seen in the surface; what media send is taken to be even.
vec3 light_around(vec3 p, vec3 d, float alpha, vec3 irradiance, vec3 open)
{
    vec3 light = irradiance / kPi;
    if (kEnvironment) {
        vec3 seen = min(irradiance / max(open, 1e-20), 1.0);
        light = seen * world_reflection(d, alpha) + (irradiance - seen * open) / kPi;
    }
    if (kProbes)
        light = probes_reflection(p, d, alpha, light);
    return light;
}

void add_world_reflection(vec3 p, vec3 n, vec3 irradiance, vec3 open)
{
    const float kOneLobe = 0.01;   // alpha of mirrors, all but
    const float kNarrowest = 0.2;  // of a lobe, over alpha
    // About the middles of quarters of GGX's slopes along a line, over alpha, and how wide a lobe each stands for: fitted to
    // the light of lamps at 6 places by lobes of roughness 0.2 to 1 (errors squared fall by a third beside the middles
    // themselves and lobes of one width).
    const float kSlopes[kLobes] = float[kLobes](-1.05, -0.27, 0.27, 1.05);
    const float kWidths[kLobes] = float[kLobes](1.37, 0.93, 0.93, 1.37);
    float n_wo = max(dot(n, gloss.wo), 0.0);
    vec3 along = gloss.wo - n * n_wo;  // as long as the sine: none, and the lobe is round
    vec3 sum = vec3(0.0), weights = vec3(0.0);
    for (int i = 0; i < kLobes && gloss.alpha > kOneLobe; ++i) {
        vec3 h = normalize(n + along * (gloss.alpha * kSlopes[i]));
        float wo_h = dot(gloss.wo, h);
        vec3 d = 2.0 * wo_h * h - gloss.wo;
        float n_wi = dot(n, d);
        if (wo_h <= 0.0 || n_wi <= 0.0)
            continue;
        vec3 weight =
            schlick_fresnel(gloss.f0, wo_h) * (ggx_visibility(n_wo, n_wi, gloss.alpha) * n_wi * wo_h / dot(n, h));
        sum += weight * light_around(p, d, gloss.alpha * max(kWidths[i] * wo_h, kNarrowest), irradiance, open);
        weights += weight;
    }
    vec3 light = weights.g > 0.0 ? sum / max(weights, 1e-20)
                                 : light_around(p, reflect(-gloss.wo, n), gloss.alpha, irradiance, open);
    reflected += ggx_once(gloss.f0, gloss.ab) * light;
}
