#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

// Directions by chance.

namespace fumarole::study {

/// The direction at an angle, by its cosine, to an axis, and at an angle phi around it.
inline glm::dvec3 directed(glm::dvec3 axis, double cosine, double phi)
{
    const glm::dvec3 helper = std::abs(axis.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
    const glm::dvec3 right = glm::normalize(glm::cross(helper, axis));
    const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
    return cosine * axis + sine * (std::cos(phi) * right + std::sin(phi) * glm::cross(axis, right));
}

/// A cosine whose density is Henyey and Greenstein's phase, by inversion.
inline double sample_henyey_greenstein(double g, double u)
{
    if (std::abs(g) < 1e-4)
        return 2 * u - 1 + 1.5 * g * (1 - std::pow(2 * u - 1, 2));  // to the first order of g
    const double root = (1 - g * g) / (1 - g + 2 * g * u);
    return std::clamp((1 + g * g - root * root) / (2 * g), -1.0, 1.0);
}

}  // namespace fumarole::study
