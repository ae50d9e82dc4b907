#pragma once

#include <vector>

#include "bounds.h"
#include "medium/grid_layout.h"

namespace fumarole::medium {

/// A part of a medium's space that may hold something.
struct OccupiedBox {
    Bounds bounds;
    float most = 0;  ///< of the field inside, in the grid's units
};

/// Boxes in the layout's index space (its texel (0,0,0) is the origin) outside which the field is
/// 0: its pages that are not empty, joined by 2^3, 4^3, ... until there are no more than `limit`.
std::vector<OccupiedBox> occupied_boxes(const GridLayout& layout, std::size_t limit);

}  // namespace fumarole::medium
