#pragma once

#include <glm/glm.hpp>
#include <vector>

#include <fumarole/scene.h>

namespace fumarole::light {

/// Mean radiance over all directions [W/m^2/sr].
glm::vec3 mean_radiance(const Environment& environment);

/// Irradiance [W/m^2] of an unhidden surface by its normal, in the same latitude-longitude form:
/// the cosine-weighted integral over the hemisphere, summed over at most 64 x 32 averages, each of
/// which has its light where the mean of it lies.
Environment irradiance_map(const Environment& environment);

/// Radiance [W/m^2/sr] of an environment from `directions` (unit length, a few dozen all around)
/// that stand for `solid_angles` [sr]: each texel's light is shared out among the three that it
/// lies amid, and then their sum is given the environment's own spherical harmonics of bands 0 to
/// 3, as far as that leaves no direction with less than nothing.
std::vector<glm::vec3> world_radiance(const World& world, const std::vector<glm::dvec3>& directions,
                                      const std::vector<double>& solid_angles);

}  // namespace fumarole::light
