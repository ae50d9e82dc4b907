#pragma once

#include "pass/froxels.h"
#include "resolve/layers.h"

namespace fumarole::resolve {

/// Draws one layer of integrated froxels, looked up at the depth of every pixel of the bound
/// framebuffer: glsl/resolve/froxels.frag.
void look_up(const Toolbox& tools, const PreparedFrame& frame,
             const pass::IntegratedFroxels& froxels, Layer layer);

}  // namespace fumarole::resolve
