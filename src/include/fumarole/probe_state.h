#pragma once

#include <optional>

#include <fumarole/scene.h>

namespace fumarole {

/// A probe of a renderer's scene, or one of those that are placed where the scene names none.
struct ProbeState {
    LightProbe probe;
    bool by_itself = false;  ///< true if it was placed automatically: the scene names none
    int captures = 0;        ///< number of captures so far
    double seconds_ago = 0;  ///< time since the last capture [s]
    /// Duration of the last capture with its filtering [ms]; known under Timing::finish.
    std::optional<double> capture_ms = {};
};

}  // namespace fumarole
