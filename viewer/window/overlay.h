#pragma once

#include "window/document.h"
#include "window/layout.h"
#include "window/notices.h"
#include "window/pointer_input.h"
#include "window/viewport.h"

namespace fumarole::window {

/// What is told about the picture, over the picture itself.
struct OverlayContext {
    const Layout& layout;
    const ViewState& state;
    const Document& document;
    const Viewport& viewport;
    const PointerInput& pointer;
    const Notices& notices;
};

/// Draws names of the sides, the legend of false colours, handles of lights and transparents,
/// notes, and what is read; in a window that is empty or too small, what to do about it. ImGui
/// calls.
void draw_overlay(const OverlayContext& context);

}  // namespace fumarole::window
