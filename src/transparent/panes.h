#pragma once

#include <vector>

#include "prepared_frame.h"
#include "shared/pane_params.h"
#include "transparent/order.h"

namespace fumarole::transparent {

/// Transparents in order as panes, each once.
/// @param ordered are told which pane they are, or are pieces of
/// @returns nothing if one is not flat, or they are more than MAX_PANES
std::vector<Placed> panes_of(std::vector<Placed>& ordered);

/// Whether a march does well to keep what it meets where each ray meets each of them: between two
/// rays of its layer lies no more of the depth of one than between two of the depths that it would
/// keep else.
bool suit_march(const std::vector<Placed>& panes, const PreparedFrame& frame);

/// What the panes' block holds. What they look like is said of those of one colour.
shared::PaneParams pane_params(const TransparentSet& transparents, const std::vector<Placed>& panes,
                               const PreparedFrame& frame);

}  // namespace fumarole::transparent
