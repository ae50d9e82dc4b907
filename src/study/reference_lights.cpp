#include "study/reference_lights.h"

#include <algorithm>
#include <cmath>

#include "overloaded.h"

namespace fumarole::study {

ReferenceLight::ReferenceLight(const Light& light)
{
    std::visit(Overloaded{[&](const SunLight& sun) {
                              place_ = {true, glm::normalize(sun.direction_to_light)};
                              intensity_ = sun.irradiance;
                          },
                          [&](const PointLight& point) {
                              place_ = {false, point.position};
                              intensity_ = point.radiant_intensity;
                          },
                          [&](const SpotLight& spot) {
                              place_ = {false, spot.position};
                              intensity_ = spot.radiant_intensity;
                              axis_ = glm::normalize(spot.direction);
                              edge_ = std::cos(glm::radians(spot.cone_deg) / 2);
                              inner_ = edge_ + (1 - edge_) * spot.blend;
                          }},
               light);
}

glm::dvec3 ReferenceLight::irradiance(glm::dvec3 p) const
{
    if (place_.far)
        return intensity_;
    const glm::dvec3 d = p - place_.at;
    const double range2 = std::max(glm::dot(d, d), kLeastRange * kLeastRange);
    glm::dvec3 e = intensity_ / range2;
    if (axis_ != glm::dvec3(0)) {
        const double c = glm::dot(d, axis_) / std::sqrt(range2);
        if (c <= edge_)
            return glm::dvec3(0);
        if (c < inner_) {
            const double x = (c - edge_) / (inner_ - edge_);
            e *= x * x * (3 - 2 * x);
        }
    }
    return e;
}

void ReferenceLight::add_cone_breaks(const Ray& ray, std::vector<double>& breaks) const
{
    if (axis_ == glm::dvec3(0))
        return;
    const glm::dvec3 o = ray.origin - place_.at;
    const double ua = glm::dot(o, axis_), ub = glm::dot(ray.direction, axis_);
    for (const double cosine : {edge_, inner_}) {
        // dot(p, axis)^2 = cosine^2 |p|^2
        const double k = cosine * cosine;
        const double a = ub * ub - k, b = ua * ub - k * glm::dot(o, ray.direction);
        const double c = ua * ua - k * glm::dot(o, o), d = b * b - a * c;
        if (!(d >= 0))
            continue;
        const double q = -(b + std::copysign(std::sqrt(d), b));
        for (const double t : {q / a, c / q})
            if (std::isfinite(t))
                breaks.push_back(t);
    }
}

Equiangular::Equiangular(const Ray& ray, const LightPlace& light) : plain_{light.far}
{
    if (plain_)
        return;
    const glm::dvec3 to = light.at - ray.origin;
    foot_ = glm::dot(to, ray.direction);
    height_ = std::max(glm::length(to - foot_ * ray.direction), ReferenceLight::kLeastRange);
}

double Equiangular::from_t(double t) const
{
    return plain_ ? t : std::atan((t - foot_) / height_);
}

double Equiangular::to_t(double x) const
{
    return plain_ ? x : foot_ + height_ * std::tan(x);
}

double Equiangular::dt_dx(double x) const
{
    if (plain_)
        return 1;
    const double c = std::cos(x);
    return height_ / (c * c);
}

}  // namespace fumarole::study
