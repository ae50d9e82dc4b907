#pragma once

#include <span>

#include "surface/surface_set.h"
#include <fumarole/bounds.h>

namespace fumarole::light {

/// The box that is all that stands in `around` (metres, world): nothing hides what lies in front of
/// one of its sides. Null where nothing stands there, or something else.
[[nodiscard]] const surface::SurfaceSet::Instance*
lone_box(const Bounds& around, std::span<const surface::SurfaceSet::Instance> surfaces);

/// Of a box around media, what nodes are to lie in for the surfaces in it to be lit by them. Over a
/// ground alone: the media, and as far beyond as it reaches and glsl/scene/world_irradiance.glsl
/// lets the light of nodes fade, as nobody asks the others. Else all of it: what surfaces hide from
/// each other is known as finely as nodes lie, and it shows where they come to lie.
/// @param around, media metres, world: the media lie in the box
/// @param spacing of the nodes [m]
[[nodiscard]] Bounds lit_box(const Bounds& around, const Bounds& media,
                             std::span<const surface::SurfaceSet::Instance> surfaces,
                             double spacing);

}  // namespace fumarole::light
