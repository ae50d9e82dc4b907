#pragma once

#include "pass/ray_march.h"
#include "resolve/layers.h"

namespace fumarole::resolve {

/// Layers::resolve() of a march, with an eye to depth: glsl/resolve/upsample.glsl.
void upsample(const PreparedFrame& frame, const pass::MarchedLayer& marched, Layer layer,
              const Canvas& canvas, const gl::Defines& variant);

}  // namespace fumarole::resolve
