#pragma once

#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <vector>

#include "study/reference_geometry.h"
#include "study/reference_quadrature.h"
#include <fumarole/scene.h>

// Lights: where they are and what they send.

namespace fumarole::study {

class ReferenceLight {
public:
    explicit ReferenceLight(const Light& light);

    [[nodiscard]] const LightPlace& place() const { return place_; }
    [[nodiscard]] bool black() const { return intensity_ == glm::dvec3(0); }

    /// On a plane at p that faces the light, if nothing is in between [W/m^2].
    [[nodiscard]] glm::dvec3 irradiance(glm::dvec3 p) const;

    /// The sum of a function over the light's parts, lights of one place each: of one that has no
    /// area the light itself. An area is cut into quarters until they agree with what is cut.
    /// @param of `Value of(const ReferenceLight& part, double& error)`, which adds to `error`
    template <typename Of>
    auto over_parts(const Accuracy& accuracy, double& error, const Of& of) const
    {
        if (!has_area())
            return of(*this, error);
        double unused = 0;
        return refine(accuracy, error, of, {0, 0}, 1, over_square(of, unused, {0, 0}, 1));
    }

    [[nodiscard]] bool has_area() const { return area_ > 0; }
    /// Of a light that has an area the point at `at` of the unit square, which the area is spread
    /// over evenly, with a share of all that it sends.
    [[nodiscard]] ReferenceLight part(glm::dvec2 at, double share) const;

    /// What a ray finds of a light that has an area.
    struct Seen {
        double range = kInfinity;  ///< metres; kInfinity: nothing
        glm::dvec3 radiance{0};    ///< W/m^2/sr
        double pdf = 0;            ///< pdf of the ray's direction, if part() has chosen it [1/sr]
    };
    [[nodiscard]] Seen seen(const Ray& ray) const;

    /// Where a ray crosses the edges of a spot's cone, or an area's plane.
    void add_cone_breaks(const Ray& ray, std::vector<double>& breaks) const;

    /// Nearer than this a point light counts as this near, where 1/d^2 would have no bound [m].
    static constexpr double kLeastRange = 1e-5;

private:
    void set_area(glm::dvec3 u, glm::dvec3 v, glm::dvec3 radiance, bool two_sided);

    /// Gauss and Legendre's four points of a square.
    template <typename Of>
    auto over_square(const Of& of, double& error, glm::dvec2 low, double side) const
    {
        const auto at = [&](double x, double y) {
            return of(part(low + side * glm::dvec2(x, y), side * side / 4), error);
        };
        constexpr double kNear = 0.21132486540518711775, kFar = 1 - kNear;  // (1 - 1 / sqrt(3)) / 2
        return at(kNear, kNear) + at(kFar, kNear) + at(kNear, kFar) + at(kFar, kFar);
    }

    template <typename Of, typename Value>
    Value refine(const Accuracy& accuracy, double& error, const Of& of, glm::dvec2 low, double side,
                 const Value& whole) const
    {
        const double half = side / 2;
        const auto corner = [&](int i) { return low + half * glm::dvec2(i % 2, i / 2); };
        std::array<Value, 4> quarters;
        Value sum(0);
        double own = 0;
        for (int i = 0; i < 4; ++i)
            sum += quarters.at(static_cast<std::size_t>(i)) = over_square(of, own, corner(i), half);
        constexpr double kSmallest = 1.0 / 64;
        const double miss = size_of(sum - whole);
        if (miss <= side * std::max(accuracy.absolute, accuracy.relative * size_of(sum)) ||
            half <= kSmallest) {
            error += own + miss / 4;
            return sum;
        }
        Value refined(0);
        for (int i = 0; i < 4; ++i)
            refined += refine(accuracy, error, of, corner(i), half,
                              quarters.at(static_cast<std::size_t>(i)));
        return refined;
    }
    static double size_of(glm::dvec3 value) { return largest(value); }
    static double size_of(const glm::dmat2x3& pair)
    {
        return std::max(largest(pair[0]), largest(pair[1]));
    }

    LightPlace place_;
    glm::dvec3 intensity_{0};
    glm::dvec3 axis_{0};           ///< axis of a spot; 0: none
    double edge_ = 0, inner_ = 0;  ///< cosines where its light begins and where it is whole
    double area_ = 0;              ///< [m^2]; 0: it has none
    glm::dvec3 u_{0}, v_{0};       ///< half edges of an area, or its radii [m]
    glm::dvec3 normal_{0};         ///< where an area shines
    bool two_sided_ = false, is_disk_ = false;
};

/// Stretches a ray's parameter so that a light near it costs no more than one far away: equal steps
/// of the angle at the light (Kulla and Fajardo 2012). For a sun it leaves t alone.
class Equiangular {
public:
    Equiangular(const Ray& ray, const LightPlace& light);

    [[nodiscard]] double from_t(double t) const;
    [[nodiscard]] double to_t(double x) const;
    [[nodiscard]] double dt_dx(double x) const;

private:
    bool plain_ = true;
    double foot_ = 0, height_ = 1;  ///< metres: of the place nearest to the light
};

}  // namespace fumarole::study
