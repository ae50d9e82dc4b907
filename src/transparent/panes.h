#pragma once

#include <vector>

#include "prepared_frame.h"
#include "shared/pane_params.h"
#include "transparent/order.h"

namespace fumarole::transparent {

/// Whether a march does well to keep what it meets where each ray meets each of them: they are
/// flat and whole, no more than MAX_PANES, and between two rays of its layer lies no more of the
/// depth of one than between two of the depths that it would keep else.
bool suit_march(const std::vector<Placed>& ordered, const PreparedFrame& frame);

/// Transparents in order as panes, no more than MAX_PANES. What they look like is said of those of
/// one colour.
shared::PaneParams pane_params(const TransparentSet& transparents,
                               const std::vector<Placed>& ordered, const PreparedFrame& frame);

}  // namespace fumarole::transparent
