#pragma once

#include <glm/glm.hpp>

namespace fumarole {

/// A box along the axes of its space.
struct Bounds {
    glm::dvec3 min{1e300}, max{-1e300};

    [[nodiscard]] bool empty() const { return min.x > max.x; }
    void add(glm::dvec3 p)
    {
        min = glm::min(min, p);
        max = glm::max(max, p);
    }
    void add(const Bounds& other)
    {
        min = glm::min(min, other.min);
        max = glm::max(max, other.max);
    }
    /// Whether all of another box lies in this one.
    [[nodiscard]] bool contains(const Bounds& other) const
    {
        return glm::all(glm::lessThanEqual(min, other.min)) &&
               glm::all(glm::lessThanEqual(other.max, max));
    }
    /// Whether some place lies in both, be it on a face of each.
    [[nodiscard]] bool meets(const Bounds& other) const
    {
        return glm::all(glm::lessThanEqual(min, other.max)) &&
               glm::all(glm::lessThanEqual(other.min, max));
    }
    /// What lies in both, of two that meet.
    [[nodiscard]] Bounds common(const Bounds& other) const
    {
        return {glm::max(min, other.min), glm::min(max, other.max)};
    }
    [[nodiscard]] double diagonal() const { return empty() ? 0 : glm::length(max - min); }
    /// The corner whose bits pick min or max along x, y, z.
    [[nodiscard]] glm::dvec3 corner(int i) const
    {
        return {(i & 1) != 0 ? max.x : min.x, (i & 2) != 0 ? max.y : min.y,
                (i & 4) != 0 ? max.z : min.z};
    }
    /// The box that holds this one's corners after an affine map.
    [[nodiscard]] Bounds transformed(const glm::dmat4& map) const
    {
        Bounds image;
        for (int i = 0; i < 8 && !empty(); ++i)
            image.add(glm::dvec3(map * glm::dvec4(corner(i), 1.0)));
        return image;
    }
};

}  // namespace fumarole
