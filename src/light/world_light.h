#pragma once

#include <glm/glm.hpp>

#include "scene.h"

namespace fumarole::light {

/// Mean radiance over all directions [W/m^2/sr].
glm::vec3 mean_radiance(const Environment& environment);

/// Irradiance [W/m^2] of an unhidden surface by its normal, in the same latitude-longitude form:
/// the cosine-weighted integral over the hemisphere, summed over texels of at most 128 x 64
/// averages.
Environment irradiance_map(const Environment& environment, int width, int height);

}  // namespace fumarole::light
