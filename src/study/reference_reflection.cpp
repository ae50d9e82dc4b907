#include "study/reference_reflection.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <numbers>

namespace fumarole::study {

namespace {

constexpr double kPi = std::numbers::pi;

double mean_of(glm::dvec3 v)
{
    return (v.x + v.y + v.z) / 3;
}

double schlick_weight(double cosine)
{
    return std::pow(1 - std::min(cosine, 1.0), 5);
}

glm::dvec3 mirrored(glm::dvec3 wo, glm::dvec3 h)
{
    return 2 * glm::dot(wo, h) * h - wo;
}

}  // namespace

// --------------------------------------------------------------------------------- the layer

SurfaceGloss::SurfaceGloss(const Gloss& gloss) : metallic_{gloss.metallic}
{
    // With less a light that is a point would be seen in no pixel's middle.
    constexpr double kLeastAlpha = 0.002;
    const double roughness = gloss.roughness;
    alpha_ = std::max(roughness * roughness, kLeastAlpha);
    // A scene is made ready more than once, and its roughnesses are few.
    static std::mutex guard;
    static std::map<double, std::shared_ptr<const Shares>> known;
    const std::lock_guard lock(guard);
    std::shared_ptr<const Shares>& here = known[alpha_];
    if (here == nullptr)
        here = std::make_shared<Shares>(shares());
    reflected_ = here;
}

SurfaceGloss::Shares SurfaceGloss::shares() const
{
    Shares found;
    constexpr int kCosines = 257, kRings = 128, kSpokes = 64;
    for (int i = 0; i < kCosines; ++i) {
        const double cosine = std::max(std::pow(i / (kCosines - 1.0), 3), 1e-9);
        const glm::dvec3 wo(std::sqrt(1 - cosine * cosine), 0, cosine);
        glm::dvec2 sum(0);
        for (int j = 0; j < kRings; ++j) {
            // Dense at the lobe's long tail, u = 1.
            const double rest = 1 - (j + 0.5) / kRings, u = 1 - rest * rest;
            for (int k = 0; k < kSpokes; ++k) {
                const glm::dvec3 h = visible_normal(wo, u, (k + 0.5) / kSpokes);
                const glm::dvec3 wi = mirrored(wo, h);
                if (!(wi.z > 0))
                    continue;
                // The BRDF times the cosine over the density, in which D cancels.
                const double weight = 2 * rest * wi.z * (wo.z + smith(wo.z)) /
                                      (wi.z * smith(wo.z) + wo.z * smith(wi.z));
                const double grazing = schlick_weight(glm::dot(wo, h));
                sum += weight * glm::dvec2(1 - grazing, grazing);
            }
        }
        found.push_back(sum / static_cast<double>(kRings * kSpokes));
    }
    return found;
}

glm::dvec2 SurfaceGloss::reflected(double cosine) const
{
    const Shares& shares = *reflected_;
    const double at =
        std::cbrt(std::clamp(cosine, 0.0, 1.0)) * static_cast<double>(shares.size() - 1);
    const std::size_t low = std::min(static_cast<std::size_t>(at), shares.size() - 2);
    return glm::mix(shares[low], shares[low + 1], at - static_cast<double>(low));
}

double SurfaceGloss::distribution(glm::dvec3 h) const
{
    // (n.h)^2 (alpha^2 - 1) + 1 without cancellation.
    const double a2 = alpha_ * alpha_, d = h.x * h.x + h.y * h.y + a2 * h.z * h.z;
    return a2 / (kPi * d * d);
}

double SurfaceGloss::smith(double cosine) const
{
    const double a2 = alpha_ * alpha_;
    return std::sqrt(a2 + (1 - a2) * cosine * cosine);
}

double SurfaceGloss::operator()(glm::dvec3 wo, glm::dvec3 wi) const
{
    const double visible = 0.5 / (wi.z * smith(wo.z) + wo.z * smith(wi.z));
    return distribution(glm::normalize(wo + wi)) * visible * wi.z;
}

double SurfaceGloss::pdf(glm::dvec3 wo, glm::dvec3 wi) const
{
    // G1 D over four times the cosine to the normal.
    return distribution(glm::normalize(wo + wi)) / (2 * (wo.z + smith(wo.z)));
}

glm::dvec3 SurfaceGloss::visible_normal(glm::dvec3 wo, double u, double v) const
{
    // A point of the disk that a half sphere shows, once the surface is stretched to alpha 1.
    const glm::dvec3 seen = glm::normalize(glm::dvec3(alpha_ * wo.x, alpha_ * wo.y, wo.z));
    const double across = seen.x * seen.x + seen.y * seen.y;
    const glm::dvec3 t1 =
        across > 0 ? glm::dvec3(-seen.y, seen.x, 0) / std::sqrt(across) : glm::dvec3(1, 0, 0);
    const glm::dvec3 t2 = glm::cross(seen, t1);
    const double r = std::sqrt(u), phi = 2 * kPi * v;
    const double p1 = r * std::cos(phi), s = 0.5 * (1 + seen.z);
    const double p2 = (1 - s) * std::sqrt(std::max(0.0, 1 - p1 * p1)) + s * r * std::sin(phi);
    const glm::dvec3 normal =
        p1 * t1 + p2 * t2 + std::sqrt(std::max(0.0, 1 - p1 * p1 - p2 * p2)) * seen;
    return glm::normalize(
        glm::dvec3(alpha_ * normal.x, alpha_ * normal.y, std::max(1e-12, normal.z)));
}

// ------------------------------------------------------------------------- layer and base

SurfaceReflection::SurfaceReflection(const SurfaceHit& hit, glm::dvec3 wo)
    : gloss_{hit.gloss}, base_{hit.albedo}
{
    // An interpolated normal may look away from the eye.
    z_ = glm::dot(hit.shading, wo) > 0 ? hit.shading : hit.normal;
    const glm::dvec3 helper = std::abs(z_.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
    x_ = glm::normalize(glm::cross(helper, z_));
    y_ = glm::cross(z_, x_);
    wo_ = local(wo);
    if (gloss_ == nullptr)
        return;
    constexpr double kDielectric = 0.04;
    f0_ = glm::mix(glm::dvec3(kDielectric), base_, gloss_->metallic());
    const glm::dvec2 shares = gloss_->reflected(wo_.z);
    const double lost = 1 - shares.x - shares.y;
    const glm::dvec3 once = f0_ * shares.x + shares.y;
    const glm::dvec3 mean_fresnel = f0_ + (1.0 - f0_) / 21.0;
    const glm::dvec3 more = lost * once * mean_fresnel / (1.0 - mean_fresnel * lost);
    base_ = more + (1 - gloss_->metallic()) * base_ * (1.0 - once - more);
    // The lobe is bright where it is small: it gets a quarter of the directions at least.
    layer_share_ = std::max(0.25, mean_of(once) / mean_of(once + base_));
}

glm::dvec3 SurfaceReflection::local(glm::dvec3 w) const
{
    return {glm::dot(w, x_), glm::dot(w, y_), glm::dot(w, z_)};
}

glm::dvec3 SurfaceReflection::fresnel(double cosine) const
{
    return f0_ + (1.0 - f0_) * schlick_weight(cosine);
}

glm::dvec3 SurfaceReflection::operator()(glm::dvec3 wi) const
{
    const glm::dvec3 l = local(wi);
    if (!(l.z > 0 && wo_.z > 0))
        return glm::dvec3(0);
    const glm::dvec3 below = base_ * (l.z / kPi);
    if (gloss_ == nullptr)
        return below;
    return below + fresnel(glm::dot(wo_, glm::normalize(wo_ + l))) * (*gloss_)(wo_, l);
}

double SurfaceReflection::pdf(glm::dvec3 wi) const
{
    const glm::dvec3 l = local(wi);
    if (!(l.z > 0 && wo_.z > 0))
        return 0;
    const double below = (1 - layer_share_) * l.z / kPi;
    return gloss_ == nullptr ? below : below + layer_share_ * gloss_->pdf(wo_, l);
}

std::optional<SurfaceReflection::Direction> SurfaceReflection::sample(double u, double v,
                                                                      double which) const
{
    if (!(wo_.z > 0))
        return std::nullopt;
    glm::dvec3 l;
    if (which < layer_share_) {
        l = mirrored(wo_, gloss_->visible_normal(wo_, u, v));
    } else {
        const double r = std::sqrt(u), phi = 2 * kPi * v;
        l = {r * std::cos(phi), r * std::sin(phi), std::sqrt(1 - u)};
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
