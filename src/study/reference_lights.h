#pragma once

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

    /// The sum of a function over the light's parts, lights of one place each: here the light
    /// itself.
    /// @param of `Value of(const ReferenceLight& part, double& error)`, which adds to `error`
    template <typename Of> auto over_parts(const Accuracy&, double& error, const Of& of) const
    {
        return of(*this, error);
    }

    /// Where a ray crosses the edges of a spot's cone.
    void add_cone_breaks(const Ray& ray, std::vector<double>& breaks) const;

    /// Nearer than this a point light counts as this near, where 1/d^2 would have no bound [m].
    static constexpr double kLeastRange = 1e-5;

private:
    LightPlace place_;
    glm::dvec3 intensity_{0};
    glm::dvec3 axis_{0};           ///< of a spot; 0: none
    double edge_ = 0, inner_ = 0;  ///< cosines where its light begins and where it is whole
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
