#pragma once

#include <string>
#include <vector>

#include "light/surface_rays.h"
#include "medium/media_set.h"
#include <fumarole/scene.h>

namespace fumarole::light {

struct ProbePlaces {
    std::vector<LightProbe> probes;
    std::string why;  ///< they are there, or are not, with the figure that decided; a line
};

/// Probes for a scene's glossy surfaces where they reflect enough of other surfaces and of media:
/// in the middle of each ball, where one sees what the ball does, and one amid all others, at the
/// free place nearest to their middle, each weighed by what of a white picture it would reflect of
/// them.
ProbePlaces place_probes(const Scene& scene, const medium::MediaSet& media);

/// The surfaces that a probe had better not see, a flag each: glossy balls and meshes of which it
/// sees more than any other glossy surface does. One that bulges never sees itself, but would be in
/// the way of most that it reflects.
std::vector<bool> unseen_by(const LightProbe& probe, const std::vector<Surface>& surfaces);

}  // namespace fumarole::light
