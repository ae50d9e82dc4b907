#pragma once

#include <string>
#include <vector>

#include "toolbox.h"

namespace fumarole {

/// Which variant of the shaders a scene and its settings need, and why: a line each.
/// @param surfaces of the scene
std::vector<std::string> explain(const Toolbox& tools, int surfaces, const FrameSettings& settings);

}  // namespace fumarole
