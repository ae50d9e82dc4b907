#pragma once

#include <vector>

#include "medium/grid_layout.h"
#include <fumarole/bounds.h>

namespace fumarole::medium {

/// A part of a medium's space that may hold something.
struct OccupiedBox {
    Bounds bounds;
    float most = 0;  ///< majorant of the field inside, in the grid's units
};

// Boxes of a layout's index space: its texel (0,0,0) is the origin.

/// What a layout keeps: its bricks that are not empty, whole, or all of a dense one's field. Of a
/// tree of pages up to `limit` boxes around them.
std::vector<OccupiedBox> kept_boxes(const GridLayout& layout, std::size_t limit);

/// Boxes outside which the field is at most `least`: the layout's pages with more, without what
/// reaches out of the field, joined by 2^3, 4^3, ... until there are no more than `limit`.
std::vector<OccupiedBox> occupied_boxes(const GridLayout& layout, std::size_t limit,
                                        float least = 0);

/// Boxes around parts that lie far apart, as far as `limit` of them do: where, along an axis, more
/// is empty between two of them than is filled in all. No two of them overlap. One where nothing
/// lies so.
std::vector<Bounds> islands(const std::vector<OccupiedBox>& boxes, std::size_t limit);

}  // namespace fumarole::medium
