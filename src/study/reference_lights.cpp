#include "study/reference_lights.h"

#include <algorithm>
#include <cmath>
#include <numbers>

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
                          },
                          [&](const RectLight& rect) {
                              place_ = {false, rect.center};
                              set_area(0.5 * rect.edges[0], 0.5 * rect.edges[1], rect.radiance,
                                       rect.two_sided);
                          },
                          [&](const DiskLight& disk) {
                              // Any two radii square to each other, of which -u x v is the normal.
                              const glm::dvec3 n = glm::normalize(disk.normal);
                              const glm::dvec3 u = glm::normalize(
                                  glm::cross(n, std::abs(n.x) < 0.5 ? glm::dvec3(1, 0, 0)
                                                                    : glm::dvec3(0, 1, 0)));
                              place_ = {false, disk.center};
                              is_disk_ = true;
                              set_area(disk.radius * u, disk.radius * glm::cross(u, n),
                                       disk.radiance, disk.two_sided);
                          }},
               light);
}

void ReferenceLight::set_area(glm::dvec3 u, glm::dvec3 v, glm::dvec3 radiance, bool two_sided)
{
    const glm::dvec3 across = glm::cross(u, v);
    area_ = glm::length(across) * (is_disk_ ? std::numbers::pi : 4);
    intensity_ = radiance * area_;
    u_ = u;
    v_ = v;
    normal_ = -glm::normalize(across);
    two_sided_ = two_sided;
}

ReferenceLight ReferenceLight::part(glm::dvec2 at, double share) const
{
    ReferenceLight point = *this;
    point.intensity_ *= share;
    glm::dvec2 place = 2.0 * at - 1.0;
    if (is_disk_) {
        const double angle = 2 * std::numbers::pi * at.y;
        place = std::sqrt(at.x) * glm::dvec2(std::cos(angle), std::sin(angle));
    }
    point.place_.at += place.x * u_ + place.y * v_;
    return point;
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
    if (has_area()) {
        const double c = glm::dot(d, normal_) / std::sqrt(range2);
        e *= two_sided_ ? std::abs(c) : std::max(c, 0.0);
    }
    return e;
}

ReferenceLight::Seen ReferenceLight::seen(const Ray& ray) const
{
    const double slope = glm::dot(ray.direction, normal_);
    if (slope == 0 || (!two_sided_ && slope > 0))
        return {};
    const double t = glm::dot(place_.at - ray.origin, normal_) / slope;
    if (!(t > 0))
        return {};
    const glm::dvec3 from_center = ray.at(t) - place_.at;
    const double x = glm::dot(from_center, u_) / glm::dot(u_, u_),
                 y = glm::dot(from_center, v_) / glm::dot(v_, v_);
    if (is_disk_ ? x * x + y * y > 1 : std::max(std::abs(x), std::abs(y)) > 1)
        return {};
    return {t, intensity_ / area_, t * t / (std::abs(slope) * area_)};
}

void ReferenceLight::add_cone_breaks(const Ray& ray, std::vector<double>& breaks) const
{
    if (has_area())  // there it is seen edge on
        if (const double slope = glm::dot(ray.direction, normal_); slope != 0)
            breaks.push_back(glm::dot(place_.at - ray.origin, normal_) / slope);
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
