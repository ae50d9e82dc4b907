#pragma once

#include <string>

#include "window/document.h"
#include "window/viewport.h"

// What a person takes away from the window: pictures, the scene, the command line.

namespace fumarole::window {

/// A name that no file has yet, after the scene's file: smoke.png, smoke_2.png, ...
std::string unused_name(const std::string& scene_file, const std::string& extension);

/// Writes what is on the screen, at its size, as the command line would make it; .png or .exr.
/// @param pixels size of the picture
/// @throws Error if the reference is shown and not whole yet, or as the writers do
void save_picture(const std::string& file, const Document& document, const ViewState& state,
                  Viewport& viewport, glm::ivec2 pixels);

/// The command line that makes what is on the screen. A scene that was edited is written for it, to
/// a file of the user's cache named after what it holds.
/// @throws Error if that file can't be written
std::string copied_command(const Document& document, const ViewState& state, glm::ivec2 pixels);

}  // namespace fumarole::window
