#pragma once

#include "gl/framebuffer.h"
#include "resolve/layers.h"

namespace fumarole::resolve {

/// Blends the layers of the last draw() over the framebuffer's colour, whose alpha stays:
/// color * transmittance + scattering. With grey transmittance, or in one pass, the blending stage
/// does both at once; in two, transmittance multiplies and scattering is added, as in 2017.
void composite(const Toolbox& tools, Layers& layers, const gl::Framebuffer& picture,
               const PreparedFrame& frame);

/// Draws one of the layers of the last draw() over the bound framebuffer, three channels each; what
/// it holds before is what is where there is no medium: 0 for scattering, 1 for transmittance.
void draw_layer(const Toolbox& tools, Layers& layers, const PreparedFrame& frame, Layer layer);

}  // namespace fumarole::resolve
