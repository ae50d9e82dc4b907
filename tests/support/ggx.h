#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>

// The BRDF of docs/methods.md, "Surfaces", in double precision and as the formulas stand there.

namespace fumarole::test {

inline double ggx_alpha(double roughness)
{
    return std::max(roughness * roughness, 0.002);
}

/// D V [1/sr]; n_h, n_wo, n_wi > 0.
inline double ggx_d_v(double n_h, double n_wo, double n_wi, double alpha)
{
    const double a2 = alpha * alpha, d = n_h * n_h * (a2 - 1) + 1;
    const double v = 0.5 / (n_wi * std::sqrt(a2 + (1 - a2) * n_wo * n_wo) +
                            n_wo * std::sqrt(a2 + (1 - a2) * n_wi * n_wi));
    return a2 / (std::numbers::pi * d * d) * v;
}

/// D V F [1/sr]; all of unit length, wi above the surface.
inline glm::dvec3 ggx_reflection(glm::dvec3 n, glm::dvec3 wo, glm::dvec3 wi, double alpha,
                                 glm::dvec3 f0)
{
    const glm::dvec3 h = glm::normalize(wo + wi);
    const double fresnel = std::pow(1 - glm::dot(wo, h), 5);
    return ggx_d_v(glm::dot(n, h), glm::dot(n, wo), glm::dot(n, wi), alpha) *
           (f0 + (1.0 - f0) * fresnel);
}

/// Calls f(wi, weight) for half vectors spread as wo sees them (Heitz 2018, "Sampling the GGX
/// Distribution of Visible Normals"), n along z: the sum of weight is the integral of D V n.wi over
/// wi.
template <class F> void over_ggx_lobe(glm::dvec3 wo, double alpha, int rings, int turns, F&& f)
{
    const double a2 = alpha * alpha;
    const glm::dvec3 v = glm::normalize(glm::dvec3(alpha * wo.x, alpha * wo.y, wo.z));
    const glm::dvec3 x = v.z < 1 ? glm::normalize(glm::dvec3(-v.y, v.x, 0)) : glm::dvec3(1, 0, 0);
    const glm::dvec3 y = glm::cross(v, x);
    const double seen = 2 * wo.z / (wo.z + std::sqrt(a2 + (1 - a2) * wo.z * wo.z));
    for (int i = 0; i < rings; ++i)
        for (int j = 0; j < turns; ++j) {
            const double r = std::sqrt((i + 0.5) / rings);
            const double phi = 2 * std::numbers::pi * (j + 0.5) / turns, s = 0.5 * (1 + v.z);
            const double p1 = r * std::cos(phi);
            const double p2 = (1 - s) * std::sqrt(1 - p1 * p1) + s * r * std::sin(phi);
            const glm::dvec3 n =
                p1 * x + p2 * y + std::sqrt(std::max(1 - p1 * p1 - p2 * p2, 0.0)) * v;
            const glm::dvec3 h = glm::normalize(glm::dvec3(alpha * n.x, alpha * n.y, n.z));
            const glm::dvec3 wi = 2 * glm::dot(wo, h) * h - wo;
            if (wi.z <= 0)
                continue;
            const double d = h.z * h.z * (a2 - 1) + 1;
            const double density = a2 / (std::numbers::pi * d * d) * seen / (4 * wo.z);
            f(wi, ggx_d_v(h.z, wo.z, wi.z, alpha) * wi.z / density / rings / turns);
        }
}

inline glm::dvec3 direction_at(double cosine)
{
    return {std::sqrt(1 - cosine * cosine), 0, cosine};
}

/// a and b of docs/methods.md.
inline glm::dvec2 ggx_albedos(double n_wo, double alpha, int rings = 256, int turns = 64)
{
    const glm::dvec3 wo = direction_at(n_wo);
    glm::dvec2 sum(0);
    over_ggx_lobe(wo, alpha, rings, turns, [&](glm::dvec3 wi, double weight) {
        const double fresnel = std::pow(1 - glm::dot(wo, glm::normalize(wo + wi)), 5);
        sum += weight * glm::dvec2(1 - fresnel, fresnel);
    });
    return sum;
}

/// The Lambertian part over irradiance / pi.
inline glm::dvec3 ggx_base(glm::dvec3 albedo, double metallic, glm::dvec2 ab)
{
    const glm::dvec3 f0 = glm::mix(glm::dvec3(0.04), albedo, metallic);
    const glm::dvec3 once = f0 * ab.x + ab.y, f_avg = f0 + (1.0 - f0) / 21.0;
    const double lost = 1 - ab.x - ab.y;
    const glm::dvec3 more = lost * once * f_avg / (1.0 - f_avg * lost);
    return more + (1 - metallic) * albedo * (1.0 - once - more);
}

}  // namespace fumarole::test
