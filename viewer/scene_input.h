#pragma once

#include <string>
#include <string_view>

#include <fumarole/asset/scene_file.h>

namespace fumarole::command {

/// What a command is given to show, as it was typed.
struct SceneInput {
    std::string file;  ///< a .vdb, or a scene file
    std::string size;  ///< WIDTHxHEIGHT, or "" for the file's own
    std::string grid;  ///< grid of a .vdb; "" for the first fog volume
    std::string up;    ///< up axis of a .vdb: `auto`, `y`, `z`
    /// Of a sequence that plays: where a frame is missing or broken what is shown stays.
    bool hold_missing = false;
};

/// @throws UsageError if it is no WIDTHxHEIGHT, each 1..16384
glm::uvec2 parse_size(const std::string& text);

/// Whether a name ends so, whatever its case. @param extension in lower case, with its dot
bool has_extension(const std::string& file, std::string_view extension);

bool is_scene_file(const std::string& file);

/// A sequence that is named as a shell's files are, and not by its numbers.
/// @throws Error if there is no such file and the name has a * or a ?
void check_no_glob(const std::string& file);

/// Reads a scene file, or makes a scene for a bare .vdb. Of a sequence it is the first frame that
/// holds something.
/// @throws UsageError if the words don't fit; Error as the readers do.
asset::LoadedScene load_input(const SceneInput& input);

/// The scene of all frames, for asset::FrameLoader; what was chosen for a bare sequence of .vdb is
/// chosen by all of its frames. @throws as load_input
asset::LoadedScene open_moving(const SceneInput& input);

}  // namespace fumarole::command
