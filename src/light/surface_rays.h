#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include <fumarole/bounds.h>
#include <fumarole/scene.h>

namespace fumarole::light {

/// Few rays on the CPU against a scene's surfaces, for what is decided before anything is drawn. A
/// mesh of many triangles is taken for the box around it.
class SurfaceRays {
public:
    /// @param surfaces outlives this
    explicit SurfaceRays(const std::vector<Surface>& surfaces);

    struct Hit {
        double range = 0;   ///< metres
        int surface = 0;    ///< into the surfaces
        int triangle = -1;  ///< triangle of a mesh that is not taken for a box
    };
    /// The first surface on a way of unit length, from either side, but for those to be left out.
    [[nodiscard]] std::optional<Hit> first(glm::dvec3 origin, glm::dvec3 direction,
                                           const std::vector<bool>& left_out = {}) const;

    /// Of unit length, outward or not, where a way met a surface.
    [[nodiscard]] glm::dvec3 normal_of(const Hit& hit, glm::dvec3 p) const;

    /// Whether a place is inside of a surface, or nearer to one than this many metres, but for
    /// those to be left out.
    [[nodiscard]] bool is_near(glm::dvec3 p, double metres,
                               const std::vector<bool>& left_out = {}) const;

    [[nodiscard]] const Bounds& bounds_of(int surface) const
    {
        return bounds_[static_cast<std::size_t>(surface)];
    }

private:
    [[nodiscard]] Hit hit_of(std::size_t surface, glm::dvec3 origin, glm::dvec3 direction) const;

    const std::vector<Surface>& surfaces_;
    std::vector<Bounds> bounds_;  ///< bounds of each surface, metres, world
};

/// The i-th of places that are spread evenly over a box (Roberts 2018, the sequence R3).
glm::dvec3 spread_place(const Bounds& box, int i);

/// Directions that are spread evenly (a Fibonacci lattice).
std::vector<glm::dvec3> even_directions(int count);

}  // namespace fumarole::light
