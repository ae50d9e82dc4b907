#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "window/view_state.h"

// What is kept for a person from one run to the next: XDG Base Directory Specification 0.8.

namespace fumarole::window {

struct Remembered {
    std::vector<std::string> recent;  ///< files, the last one first, absolute
    std::string folder;               ///< that was looked through last, absolute
    glm::ivec2 size{1280, 720};       ///< of the window
    ViewState state;                  ///< but for what belongs to one scene alone
    std::filesystem::path file;       ///< where it is kept; "" keeps nothing
};

/// $XDG_CONFIG_HOME/fumarole/view.json, or ~/.config's. "" if there is neither.
std::filesystem::path memory_file();

/// $XDG_CACHE_HOME/fumarole, or ~/.cache's: scenes that a copied command line names.
std::filesystem::path cache_folder();

/// What the file says; what it doesn't say, or says wrongly, is as in a new one. `complaint` says
/// what could not be read, or "".
Remembered recall(const std::filesystem::path& file, std::string& complaint);

/// Writes its file, in one piece; makes the folder. @throws Error naming the file
void remember(const Remembered& what);

/// Puts a file first among the recent ones, once, ten at most.
void add_recent(Remembered& what, const std::string& file);

}  // namespace fumarole::window
