#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "window/event.h"

namespace fumarole::window {

enum class Action {
    raymarch,
    froxel,
    reference,
    split,
    difference,
    see_inside,
    fit,
    first_camera,
    lights,
    play,
    frame_back,
    frame_on,
    first_frame,
    panel,
    copy_command,
    save_png,
    save_exr,
    save_scene,
    browse,
    help,
    close,
};

struct KeyBinding {
    Action action;
    int key;
    bool control = false;
    std::string_view name;  ///< as it stands on a keyboard
    std::string_view help;  ///< one line
};

/// What a key does, as data: the program, `--help` and the overlay read this table.
const std::vector<KeyBinding>& key_table();

/// What the pointer does: gesture and meaning.
const std::vector<std::pair<std::string_view, std::string_view>>& pointer_table();

/// Both tables as lines of text.
std::string key_help();

/// A key by its name in the table, or a letter, digit or name as `left`, `escape`. -1 if unknown.
int key_called(std::string_view name);

}  // namespace fumarole::window
