#pragma once

#include <cstddef>
#include <vector>

#include "medium/occupancy.h"
#include "scene.h"

namespace fumarole::medium {

/// Boxes of `bounds`, both in metres, outside which a noise that does not drift is 0; most: an
/// upper bound of its coefficient inside. Proven from samples of it and from how fast it can bend
/// between them, so where its features are too small to be sampled within some milliseconds they
/// are taken for as large as they can be. Blocks joined until there are no more than `limit`.
std::vector<OccupiedBox> occupied_boxes(const NoiseProfile& noise, const Bounds& bounds,
                                        std::size_t limit);

}  // namespace fumarole::medium
