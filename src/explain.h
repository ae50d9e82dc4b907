#pragma once

#include <string>
#include <vector>

#include "prepared_frame.h"
#include "toolbox.h"

namespace fumarole {

/// Which variant of the shaders a scene and its settings need, and why: a line each.
/// @param surfaces of the scene
/// @param layer of a frame that was settled with such settings
std::vector<std::string> explain(const Toolbox& tools, int surfaces, const FrameSettings& settings,
                                 const LayerChoice& layer);

}  // namespace fumarole
