#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <fumarole/export.h>
#include <fumarole/scene.h>

namespace fumarole::asset {

/// A scene and what was said while its files were read.
struct LoadedScene {
    Scene scene;
    std::vector<std::string> notes;
};

/// Reads a scene file (JSON, version 2) without opening the files that it names. Paths come out
/// resolved against the scene file's folder.
/// @throws Error with file, place (`media[1].sigma_s`, or line and column for bad JSON), what is
/// wrong and what was expected: unknown key, missing key, wrong type, number out of range or not
/// finite.
FUMAROLE_API Scene parse_scene(const std::filesystem::path& file);

/// Fills in every pointer of a scene that is still null from its file: grids, meshes, environment.
/// Each file and grid is read once, however often it is named.
/// @throws Error as the readers do.
FUMAROLE_API void load_scene_files(LoadedScene& scene);

/// parse_scene and load_scene_files.
FUMAROLE_API LoadedScene load_scene(const std::filesystem::path& file);

/// The scene in the form that parse_scene reads, paths relative to `folder` where they lie below or
/// beside it. Written numbers read back to the same bits.
FUMAROLE_API std::string scene_to_json(const Scene& scene, const std::filesystem::path& folder);

/// Writes scene_to_json beside, then renames. @throws Error naming the file.
FUMAROLE_API void save_scene(const Scene& scene, const std::filesystem::path& file);

}  // namespace fumarole::asset
