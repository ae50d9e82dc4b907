#pragma once

#include <string>

#include <fumarole/asset/scene_file.h>

namespace fumarole::command {

/// What a command is given to show, as it was typed.
struct SceneInput {
    std::string file;  ///< a .vdb, or a scene file
    std::string size;  ///< WIDTHxHEIGHT, or "" for the file's own
    std::string grid;  ///< of a .vdb; "" for the first fog volume
    std::string up;    ///< of a .vdb: `auto`, `y`, `z`
};

/// @throws UsageError if it is no WIDTHxHEIGHT, each 1..16384
glm::uvec2 parse_size(const std::string& text);

bool is_scene_file(const std::string& file);

/// Reads a scene file, or makes a scene for a bare .vdb. Of a sequence it is the first frame that
/// is there.
/// @throws UsageError if the words don't fit; Error as the readers do.
asset::LoadedScene load_input(const SceneInput& input);

/// The scene of all frames, for asset::FrameLoader; what was chosen for a bare sequence of .vdb is
/// chosen by frame `first`. @throws as load_input
asset::LoadedScene open_moving(const SceneInput& input, int first);

}  // namespace fumarole::command
