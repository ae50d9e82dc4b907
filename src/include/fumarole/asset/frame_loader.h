#pragma once

#include <future>
#include <optional>
#include <string>

#include <fumarole/asset/animation.h>
#include <fumarole/asset/scene_file.h>
#include <fumarole/export.h>

namespace fumarole::asset {

/// What becomes of a frame whose file is missing or broken.
enum class MissingFrames {
    fail,  ///< the run ends
    hold,  ///< it shows what the frame before it shows; nothing, if there is none
    skip,  ///< it is left out
};

/// The frames of a scene in time, in order. While one is shown the next one's files are read, on a
/// thread of its own.
class FUMAROLE_API FrameLoader {
public:
    /// @param scene as parse_scene gives it, or with files read: what no frame changes is read once
    FrameLoader(LoadedScene scene, FrameRange frames, MissingFrames missing = MissingFrames::fail);

    /// The next frame, or nothing where it is left out. The notes are those that its files brought
    /// anew.
    /// @throws Error if a file is missing, naming the frame and those that are there, or is bad.
    std::optional<LoadedScene> next();

private:
    void start(int frame);
    LoadedScene held(int frame, const std::string& why) const;

    LoadedScene scene_;
    FrameRange frames_;
    MissingFrames missing_;
    int next_;
    Scene last_;  ///< the last scene that was read
    std::future<LoadedScene> loading_;
};

/// @throws Error if a sequence has no file for a frame, saying which ones it has
FUMAROLE_API void check_frame(const std::filesystem::path& sequence, int frame);

/// A frame's scene with its files read. What a sequence's file lacks of the grids that its medium
/// names is empty in that frame. `like` may hold files that the frame needs as well.
/// @throws Error as FrameLoader::next().
FUMAROLE_API LoadedScene load_frame(const Scene& scene, int frame, const Scene& like);

}  // namespace fumarole::asset
