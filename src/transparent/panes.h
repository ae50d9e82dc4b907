#pragma once

#include <optional>

#include "gl/framebuffer.h"
#include "gl/texture.h"
#include "prepared_frame.h"
#include "shared/pane_params.h"
#include "transparent/transparent_set.h"

namespace fumarole::transparent {

/// A frame's transparents as panes in order, the nearest first: laid over a picture without lists.
/// @returns nothing where one is not flat or not of one colour, blends by what is behind it, or
/// crosses another, or where there are more than MAX_PANES
std::optional<shared::PaneParams> panes_in_order(const TransparentSet& transparents,
                                                 const SeenTransparents& seen,
                                                 const PreparedFrame& frame);

/// What a view's panes add to each ray of a march: glsl/transparent/pane_layer.frag.
struct PaneLayer {
    gl::Texture added;
    gl::Framebuffer framebuffer;

    void resize(const gl::Device& device, glm::ivec2 size);
};

}  // namespace fumarole::transparent
