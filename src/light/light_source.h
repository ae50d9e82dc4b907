#pragma once

#include <span>

#include "gl/program.h"
#include <fumarole/scene.h>

// The scene's lights as GLSL: written/lights.glsl, written/scattering.glsl and
// written/irradiance.glsl, which say which light is of which kind.

namespace fumarole::light {

/// What glsl/scene/lights.glsl needs. lights: each kind's in a row, in the order of Light's kinds.
gl::Defines write_lights(std::span<const Light> lights);

}  // namespace fumarole::light
