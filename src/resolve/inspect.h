#pragma once

#include <functional>

#include "pass/volume_pass.h"
#include "resolve/layers.h"
#include <fumarole/inspection.h>

namespace fumarole::resolve {

/// Draws what `wanted` asks for into `host`, a framebuffer with the frame's colour attached, whose
/// alpha stays; the depth is attached for a while. What it needs of textures is made for the call.
/// glsl/pass/inspect_*.frag: a picture of values, their ends where no scale is given, colours.
/// @param draw_counts draws how many transparent fragments each pixel of the bound framebuffer has
/// @throws Error if axis, position or scale is out of range; of a slice of froxels in another mode.
InspectionLegend inspect(const Toolbox& tools, Layers& layers, gl::Framebuffer& host,
                         const PreparedFrame& frame, const Inspection& wanted,
                         const std::function<void()>& draw_counts);

}  // namespace fumarole::resolve
