#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <fumarole/export.h>
#include <fumarole/scene.h>

// A scene in time: which files, at which frame.

namespace fumarole {

/// Whether a name has a place for a frame's number: #### (a digit each), %04d, $F4 or @@@@.
FUMAROLE_API bool has_frame_number(const std::filesystem::path& file);

/// The name with a frame's number in its place, with zeros in front as far as the place goes, the
/// sign counted: -001. Of several places the last of the first kind is meant, in the order above. A
/// name without one stays as it is.
FUMAROLE_API std::filesystem::path numbered_file(const std::filesystem::path& file, int frame);

/// Whether a file that is read stands for one a frame. A file of exactly that name comes first:
/// take#2.vdb is no sequence where it is there.
FUMAROLE_API bool is_sequence(const std::filesystem::path& file);

/// The file of one frame that is read: numbered_file, or where only that is there, -0001 for -001.
/// What is no sequence stays as it is.
FUMAROLE_API std::filesystem::path frame_file(const std::filesystem::path& file, int frame);

/// Frames first, first + step, ... up to last.
struct FrameRange {
    int first = 0, last = 0;
    int step = 1;  ///< >= 1

    [[nodiscard]] int count() const { return (last - first) / step + 1; }
};

/// Numbers of the frames of a sequence that are there, ascending.
FUMAROLE_API std::vector<int> frames_of(const std::filesystem::path& sequence);

/// The scene at a frame: time is scene.time + frame / frames_per_second, the camera is the path's,
/// and files are the frame's. What was read from a file that is another one now is let go of.
FUMAROLE_API Scene scene_at(const Scene& scene, int frame);

}  // namespace fumarole
