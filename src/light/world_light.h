#pragma once

#include <glm/glm.hpp>
#include <vector>

#include <fumarole/scene.h>

namespace fumarole::light {

/// Mean radiance over all directions [W/m^2/sr].
glm::vec3 mean_radiance(const Environment& environment);

/// Irradiance [W/m^2] of an unhidden surface by its normal, in the same latitude-longitude form:
/// the cosine-weighted integral over the hemisphere, summed over texels of at most 128 x 64
/// averages.
Environment irradiance_map(const Environment& environment, int width, int height);

/// A part of the sphere and the world's light from it.
struct WorldCell {
    glm::dvec3 wi{0};     ///< to the light, unit length: the middle of what comes from there
    glm::dvec3 power{0};  ///< radiance times solid angle, summed over the cell [W/m^2]
};

/// The world cut into at most `count` cells of about the same size; those that are black are left
/// out. Together they have all of the world's light.
std::vector<WorldCell> world_cells(const World& world, int count);

}  // namespace fumarole::light
