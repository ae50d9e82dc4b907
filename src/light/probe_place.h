#pragma once

#include <optional>
#include <string>
#include <vector>

#include "light/surface_rays.h"
#include "medium/media_set.h"
#include <fumarole/scene.h>

namespace fumarole::light {

struct ProbePlace {
    std::optional<LightProbe> probe;
    std::string why;  ///< it is there, or is not, with the figure that decided; a line
};

/// A probe amid a scene's glossy surfaces where they reflect enough of other surfaces and of media:
/// at the free place nearest to their middle, each weighed by what of a white picture it would
/// reflect of them.
ProbePlace place_probe(const Scene& scene, const medium::MediaSet& media);

/// The surfaces that a probe had better not see, a flag each: glossy balls and meshes of which it
/// sees much more than any other glossy surface does. One that bulges never sees itself, but would
/// be in the way of most that it reflects.
std::vector<bool> unseen_by(const LightProbe& probe, const std::vector<Surface>& surfaces);

}  // namespace fumarole::light
