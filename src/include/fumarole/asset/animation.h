#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <fumarole/export.h>
#include <fumarole/scene.h>

// A scene in time: which files, at which frame.

namespace fumarole {

/// Whether a file's name has #s, which stand for a frame's number: `smoke_####.vdb`.
FUMAROLE_API bool is_sequence(const std::filesystem::path& file);

/// The file of one frame: the last run of #s in the name becomes the number, with zeros in front as
/// far as the run goes. Anything else stays as it is.
FUMAROLE_API std::filesystem::path frame_file(const std::filesystem::path& file, int frame);

/// Numbers of the frames of a sequence that are there, ascending.
FUMAROLE_API std::vector<int> frames_of(const std::filesystem::path& sequence);

/// The scene at a frame: time is scene.time + frame / frames_per_second, the camera is the path's,
/// and files are the frame's. What was read from a file that is another one now is let go of.
FUMAROLE_API Scene scene_at(const Scene& scene, int frame);

/// The first frame of the scene's sequences, or nothing if it has none.
FUMAROLE_API std::optional<int> first_frame(const Scene& scene);

}  // namespace fumarole
