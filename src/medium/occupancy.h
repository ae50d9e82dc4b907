#pragma once

#include <vector>

#include "medium/grid_layout.h"
#include <fumarole/bounds.h>

namespace fumarole::medium {

/// A part of a medium's space that may hold something.
struct OccupiedBox {
    Bounds bounds;
    float most = 0;  ///< of the field inside, in the grid's units
};

// Boxes of a layout's index space: its texel (0,0,0) is the origin.

/// What a layout keeps: its bricks that are not empty, whole, or all of a dense one's field.
std::vector<OccupiedBox> kept_boxes(const GridLayout& layout);

/// Boxes outside which the field is at most `least`: the layout's pages with more, without what
/// reaches out of the field, joined by 2^3, 4^3, ... until there are no more than `limit`.
std::vector<OccupiedBox> occupied_boxes(const GridLayout& layout, std::size_t limit,
                                        float least = 0);

}  // namespace fumarole::medium
