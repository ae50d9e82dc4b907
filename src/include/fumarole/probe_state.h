#pragma once

#include <optional>

#include <fumarole/scene.h>

namespace fumarole {

/// A probe of a renderer's scene, or the one that is placed where the scene names none.
struct ProbeState {
    LightProbe probe;
    bool by_itself = false;                 ///< the scene does not name it
    int captures = 0;                       ///< in all
    double seconds_ago = 0;                 ///< that it was last captured
    std::optional<double> capture_ms = {};  ///< that took, filtering too; under Timing::finish
};

}  // namespace fumarole
