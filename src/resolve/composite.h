#pragma once

#include "resolve/layers.h"

namespace fumarole::resolve {

/// A picture to resolve to. @param texture is attached to the framebuffer
Canvas make_canvas(const Toolbox& tools, const gl::Framebuffer& framebuffer,
                   gl::TextureView texture, const FrameSettings& settings);

/// Blends the layers of the last draw() over a picture, whose alpha stays:
/// color * transmittance + scattering. With grey transmittance, or in one pass, both are done at
/// once; in two, transmittance multiplies and scattering is added, as in 2017.
void composite(const Toolbox& tools, Layers& layers, const Canvas& canvas,
               const PreparedFrame& frame);

/// Draws one of the layers of the last draw() over a picture whose framebuffer is bound, three
/// channels each; what it holds before is what is where there is no medium: 0 for scattering, 1 for
/// transmittance.
void draw_layer(const Toolbox& tools, Layers& layers, const Canvas& canvas,
                const PreparedFrame& frame, Layer layer);

}  // namespace fumarole::resolve
