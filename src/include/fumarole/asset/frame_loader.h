#pragma once

#include <future>

#include <fumarole/asset/scene_file.h>
#include <fumarole/export.h>

namespace fumarole::asset {

/// The frames of a scene in time, in order. While one is shown the next one's files are read, on a
/// thread of its own.
class FUMAROLE_API FrameLoader {
public:
    /// @param scene as parse_scene gives it, or with files read: what no frame changes is read once
    FrameLoader(LoadedScene scene, int first, int last);

    /// The next frame. The notes are those that its files brought anew.
    /// @throws Error if a file is missing, naming the frame and those that are there, or is bad.
    LoadedScene next();

private:
    void start(int frame);

    LoadedScene scene_;
    int next_, last_;
    std::future<LoadedScene> loading_;
};

/// @throws Error if a sequence has no file for a frame, saying which ones it has
FUMAROLE_API void check_frame(const std::filesystem::path& sequence, int frame);

/// A frame's scene with its files read. `like` may hold files that the frame needs as well.
/// @throws Error as FrameLoader::next().
FUMAROLE_API LoadedScene load_frame(const Scene& scene, int frame, const Scene& like);

}  // namespace fumarole::asset
