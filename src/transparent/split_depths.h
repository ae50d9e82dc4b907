#pragma once

#include <span>
#include <vector>

#include "medium/media_set.h"
#include "prepared_frame.h"

namespace fumarole::transparent {

/// view_z [m], ascending, of so many depths between which what a march has met is interpolated:
/// from the first that is asked for to the last, the closer the more of the media may lie there.
/// Half of them are spread by the media's majorants over the picture, so that each two have as much
/// optical depth between them at most, and the rest evenly.
/// @param asked nearest and farthest [m] @param count 2 at least
std::vector<float> split_depths(std::span<const medium::Occupied> occupied,
                                const PreparedFrame& frame, glm::dvec2 asked, int count);

}  // namespace fumarole::transparent
