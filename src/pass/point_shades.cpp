#include "pass/point_shades.h"

#include <algorithm>
#include <cmath>

namespace fumarole::pass {

namespace {

constexpr std::size_t kMostSurfaces = 64;  ///< more take longer to ask than they save
/// Lookups take four texels, and what covers a texel's middle is drawn in all of it: seen along a
/// face's diagonal, which is root 3 as far, on the inside of either edge.
constexpr double kRim = 6;

}  // namespace

bool comes_between(glm::dvec3 point, const Bounds& box, const Bounds& other)
{
    // At a share t of the way from the point to the box it is a box, which grows evenly.
    double first = 0, last = 1;
    const auto at_most = [&](double a, double b, double c) {  // a + b t <= c
        if (b > 0)
            last = std::min(last, (c - a) / b);
        else if (b < 0)
            first = std::max(first, (c - a) / b);
        else if (a > c)
            last = -1;
    };
    for (int axis = 0; axis < 3; ++axis) {
        const double p = point[axis];
        at_most(p, box.min[axis] - p, other.max[axis]);
        at_most(-p, p - box.max[axis], -other.min[axis]);
    }
    return first <= last;
}

bool PointShades::can_tell(const light::LightSet& lights)
{
    const auto has_area = [](const Light& light) {
        return !std::holds_alternative<SunLight>(light) &&
               !std::holds_alternative<PointLight>(light) &&
               !std::holds_alternative<SpotLight>(light);
    };
    return lights.count() > lights.suns() && lights.shaded_media() &&
           lights.caster_bounds().size() <= kMostSurfaces &&
           std::none_of(lights.lights().begin(), lights.lights().end(), has_area);
}

PointShades::PointShades(const light::LightSet& lights, const PreparedFrame& frame)
    : rays_{frame.rays}, texel_{2.0 / lights.shadow_map_size()}
{
    const glm::dvec3 eye = frame.eye.position;
    for (const LightPosition& point : lights.points())
        if (!point.far)
            lights_.push_back(point.at - eye);
    for (const Bounds& surface : lights.caster_bounds())
        surfaces_.push_back({surface.min - eye, surface.max - eye});
}

std::uint32_t PointShades::over(glm::dvec2 ndc, glm::dvec2 reach, glm::dvec2 view_z,
                                std::uint32_t among) const
{
    Bounds part;
    for (int i = 0; i < 8; ++i) {
        const glm::dvec2 at =
            ndc + reach * glm::dvec2((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1);
        const double z = (i & 4) != 0 ? view_z.y : view_z.x;
        part.add(rays_.origin + rays_.origin_dx * at.x + rays_.origin_dy * at.y +
                 (rays_.direction + rays_.direction_dx * at.x + rays_.direction_dy * at.y) * z);
    }
    std::uint32_t shaded = 0;
    for (std::size_t i = 0; i < lights_.size(); ++i) {
        if ((among >> i & 1U) == 0)
            continue;
        const double range =
            glm::length(glm::max(glm::abs(part.min - lights_[i]), glm::abs(part.max - lights_[i])));
        const glm::dvec3 rim(kRim * texel_ * range);
        for (const Bounds& surface : surfaces_)
            if (comes_between(lights_[i], part, {surface.min - rim, surface.max + rim})) {
                shaded |= 1U << i;
                break;
            }
    }
    return shaded;
}

}  // namespace fumarole::pass
