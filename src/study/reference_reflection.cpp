#include "study/reference_reflection.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace fumarole::study {

namespace {

constexpr double kPi = std::numbers::pi;

double mean_of(glm::dvec3 v)
{
    return (v.x + v.y + v.z) / 3;
}

}  // namespace

SurfaceReflection::SurfaceReflection(const SurfaceHit& hit, glm::dvec3 wo) : base_{hit.albedo}
{
    // An interpolated normal may look away from the eye.
    z_ = glm::dot(hit.shading, wo) > 0 ? hit.shading : hit.normal;
    const glm::dvec3 helper = std::abs(z_.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
    x_ = glm::normalize(glm::cross(helper, z_));
    y_ = glm::cross(z_, x_);
    wo_ = local(wo);
    if (!hit.gloss)
        return;
    constexpr double kDielectric = 0.04;
    // Narrower than this no two directions of doubles are apart.
    constexpr double kMirror = 1e-7;
    const double metallic = hit.gloss->metallic, roughness = hit.gloss->roughness;
    glossy_ = true;
    alpha_ = roughness * roughness;
    mirror_ = alpha_ < kMirror;
    f0_ = glm::mix(glm::dvec3(kDielectric), base_, metallic);
    base_ *= 1 - metallic;
    const glm::dvec3 reflected = fresnel(std::max(wo_.z, 0.0));
    const double specular = mean_of(reflected), below = mean_of(base_ * (1.0 - reflected));
    // The lobe is bright where it is small: it gets a quarter of the directions at least.
    specular_share_ = below > 0 ? std::max(0.25, specular / (specular + below)) : 1;
}

bool SurfaceReflection::black() const
{
    return !glossy_ && base_ == glm::dvec3(0);
}

glm::dvec3 SurfaceReflection::local(glm::dvec3 w) const
{
    return {glm::dot(w, x_), glm::dot(w, y_), glm::dot(w, z_)};
}

double SurfaceReflection::distribution(glm::dvec3 h) const
{
    const double a2 = alpha_ * alpha_, d = h.x * h.x + h.y * h.y + a2 * h.z * h.z;
    return a2 / (kPi * d * d);
}

double SurfaceReflection::smith(double cosine) const
{
    const double a2 = alpha_ * alpha_;
    return std::sqrt(a2 + (1 - a2) * cosine * cosine);
}

glm::dvec3 SurfaceReflection::fresnel(double cosine) const
{
    return f0_ + (1.0 - f0_) * std::pow(1 - std::min(cosine, 1.0), 5);
}

glm::dvec3 SurfaceReflection::operator()(glm::dvec3 wi) const
{
    const glm::dvec3 l = local(wi);
    if (!(l.z > 0 && wo_.z > 0))
        return glm::dvec3(0);
    const glm::dvec3 diffuse = base_ * (l.z / kPi);
    if (!glossy_)
        return diffuse;
    const glm::dvec3 h = glm::normalize(l + wo_);
    const glm::dvec3 reflected = fresnel(glm::dot(wo_, h));
    const glm::dvec3 rest = diffuse * (1.0 - reflected);
    if (mirror_)
        return rest;
    const double visible = 0.5 / (l.z * smith(wo_.z) + wo_.z * smith(l.z));
    return rest + reflected * (distribution(h) * visible * l.z);
}

double SurfaceReflection::pdf(glm::dvec3 wi) const
{
    const glm::dvec3 l = local(wi);
    if (!(l.z > 0 && wo_.z > 0))
        return 0;
    double density = (1 - specular_share_) * l.z / kPi;
    if (specular_share_ > 0 && !mirror_)
        // Of the visible normals' half vector, over four times the cosine to it: G1 D / (4 cos).
        density +=
            specular_share_ * distribution(glm::normalize(l + wo_)) / (2 * (wo_.z + smith(wo_.z)));
    return density;
}

std::optional<SurfaceReflection::Direction> SurfaceReflection::sample(double u, double v,
                                                                      double which) const
{
    if (!(wo_.z > 0))
        return std::nullopt;
    const double phi = 2 * kPi * v;
    glm::dvec3 l;
    if (which >= specular_share_) {
        const double r = std::sqrt(u);
        l = {r * std::cos(phi), r * std::sin(phi), std::sqrt(1 - u)};
    } else if (mirror_) {
        l = {-wo_.x, -wo_.y, wo_.z};
        return Direction{l.x * x_ + l.y * y_ + l.z * z_, fresnel(wo_.z) / specular_share_,
                         kInfinity};
    } else {
        // Heitz 2018, "Sampling the GGX Distribution of Visible Normals": a point of the disk that
        // a half sphere shows, seen from wo after the surface was stretched to roughness 1.
        const glm::dvec3 seen = glm::normalize(glm::dvec3(alpha_ * wo_.x, alpha_ * wo_.y, wo_.z));
        const double across = seen.x * seen.x + seen.y * seen.y;
        const glm::dvec3 t1 =
            across > 0 ? glm::dvec3(-seen.y, seen.x, 0) / std::sqrt(across) : glm::dvec3(1, 0, 0);
        const glm::dvec3 t2 = glm::cross(seen, t1);
        const double r = std::sqrt(u), p1 = r * std::cos(phi), s = 0.5 * (1 + seen.z);
        const double p2 = (1 - s) * std::sqrt(std::max(0.0, 1 - p1 * p1)) + s * r * std::sin(phi);
        const glm::dvec3 normal =
            p1 * t1 + p2 * t2 + std::sqrt(std::max(0.0, 1 - p1 * p1 - p2 * p2)) * seen;
        const glm::dvec3 h = glm::normalize(
            glm::dvec3(alpha_ * normal.x, alpha_ * normal.y, std::max(1e-12, normal.z)));
        l = 2 * glm::dot(wo_, h) * h - wo_;
    }
    if (!(l.z > 0))
        return std::nullopt;
    Direction out;
    out.wi = glm::normalize(l.x * x_ + l.y * y_ + l.z * z_);
    out.pdf = pdf(out.wi);
    if (!(out.pdf > 0))
        return std::nullopt;
    out.weight = (*this)(out.wi) / out.pdf;
    return out;
}

}  // namespace fumarole::study
