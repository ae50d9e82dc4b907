#pragma once

#include "pass/volume_pass.h"
#include "resolve/layers.h"
#include <fumarole/inspection.h>

namespace fumarole::resolve {

/// Draws what `wanted` asks for into `host`, a framebuffer with the frame's colour attached, whose
/// alpha stays; the depth is attached for a while. What it needs of textures is made for the call.
/// glsl/pass/inspect_*.frag: a picture of values, their ends where no scale is given, colours.
/// @throws Error if axis, position or scale is out of range; of a slice of froxels in another mode.
InspectionLegend inspect(const Toolbox& tools, Layers& layers, gl::Framebuffer& host,
                         const PreparedFrame& frame, const Inspection& wanted);

}  // namespace fumarole::resolve
