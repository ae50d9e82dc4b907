#pragma once

#include "pass/froxels.h"
#include "resolve/layers.h"

namespace fumarole::resolve {

/// Binds integrated froxels to be looked up at any depth: glsl/scene/volume_at_froxels.glsl, which
/// written/volume_at.glsl of the variant names. The grid's block is bound.
gl::Defines bind_lookup(const PreparedFrame& frame, const pass::IntegratedFroxels& froxels);

/// Layers::resolve() of integrated froxels, looked up at the depth of every pixel:
/// glsl/resolve/froxels.glsl.
void look_up(const Toolbox& tools, const PreparedFrame& frame,
             const pass::IntegratedFroxels& froxels, Layer layer, const Canvas& canvas,
             const gl::Defines& variant);

}  // namespace fumarole::resolve
