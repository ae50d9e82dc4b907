#pragma once

#include <algorithm>

namespace fumarole::window {

/// How much of the picture is out of date. Each kind includes those before it.
enum class Change {
    none,
    view,     ///< the camera or a setting
    frame,    ///< another frame of a sequence, for which the volumes of light are filled again
    content,  ///< an edit of media, lights or world, after which the exposure is chosen again
    scene,    ///< another scene, whose exposure is chosen from the first picture there is
};

/// Adds `change` to what is already out of date.
inline void include(Change& all, Change change)
{
    all = std::max(all, change);
}

}  // namespace fumarole::window
