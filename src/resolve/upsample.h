#pragma once

#include "pass/ray_march.h"
#include "resolve/layers.h"

namespace fumarole::resolve {

/// Draws one layer of a march at every pixel of the bound framebuffer that sees a medium, with an
/// eye to depth: glsl/resolve/upsample.frag.
void upsample(const PreparedFrame& frame, const pass::MarchedLayer& marched, Layer layer);

}  // namespace fumarole::resolve
