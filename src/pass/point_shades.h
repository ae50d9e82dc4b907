#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "light/light_set.h"
#include "prepared_frame.h"

namespace fumarole::pass {

/// Which points and spots surfaces may hide from a part of the view, told by boxes around the
/// surfaces: a light that none can hide needs no shadow map there.
class PointShades {
public:
    /// Whether it can tell: no light has an area, and the surfaces are few.
    static bool can_tell(const light::LightSet& lights);

    PointShades(const light::LightSet& lights, const PreparedFrame& frame);

    /// A bit a light, of the points and spots in their order: 0 is certain.
    /// @param ndc the middle of a rectangle of the picture @param reach half its size
    /// @param view_z from where to where [m] @param among the others are not asked, and 0
    [[nodiscard]] std::uint32_t over(glm::dvec2 ndc, glm::dvec2 reach, glm::dvec2 view_z,
                                     std::uint32_t among) const;

private:
    const CameraRays& rays_;
    std::vector<glm::dvec3> lights_;  ///< metres from the eye
    std::vector<Bounds> surfaces_;    ///< likewise
    double texel_ = 0;                ///< metres per metre of distance, of a shadow view
};

/// Whether what lies between a point and a box comes into another box.
bool comes_between(glm::dvec3 point, const Bounds& box, const Bounds& other);

}  // namespace fumarole::pass
