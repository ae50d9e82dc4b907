#pragma once

#include <functional>
#include <glm/glm.hpp>

#include <fumarole/bounds.h>
#include <fumarole/voxel_grid.h>

namespace fumarole::medium {

/// What a medium sends of its own light in all, and from where, as far as its first moments tell.
struct Glow {
    glm::dvec3 power{0};     ///< radiance per metre over the volume: W/sr, were nothing in the way
    glm::dvec3 middle{0};    ///< metres, world
    glm::dmat3 spread{0.0};  ///< covariance about the middle [m^2]
    glm::dvec3 sigma_t{0};   ///< the medium's own where it glows, on the mean [1/m]

    /// The same after an affine map that takes it to the world.
    [[nodiscard]] Glow transformed(const glm::dmat4& world_from_own) const;
    /// Metres: the edges that a box of as much spread has along its axes, the longest first, and
    /// these.
    struct Axes {
        glm::dvec3 edges{0};
        glm::dmat3 directions{1.0};
    };
    [[nodiscard]] Axes axes() const;
};

/// Of a grid, in its index space: the sum over its voxels of the radiance that each value adds
/// (a scalar's value in all three channels).
/// sigma_t_at: extinction at a place of index space; null: none
Glow glow_of(const VoxelGrid& grid, const std::function<glm::dvec3(glm::dvec3)>& radiance,
             const std::function<glm::dvec3(glm::dvec3)>& sigma_t_at);

/// Of both: in the same space.
Glow together(const Glow& a, const Glow& b);

/// Of a box whose radiance, and extinction, goes as `profile` of the height in it.
Glow glow_of(const Bounds& box, glm::dvec3 radiance, glm::dvec3 sigma_t,
             const std::function<double(double)>& profile);

}  // namespace fumarole::medium
