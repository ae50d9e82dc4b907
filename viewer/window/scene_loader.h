#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "scene_input.h"
#include "window/background.h"
#include <fumarole/asset/scene_file.h>

namespace fumarole::window {

/// Reads a scene's files on a thread of its own. What is there already can be drawn: camera, lights
/// and procedural media at once, each grid as it is read.
class SceneLoader {
public:
    /// The scene as far as it has been read.
    struct Loaded {
        asset::LoadedScene part;  ///< the scene without the media and surfaces still missing
        bool whole = false;       ///< true once all files are read
        Scene moving;             ///< the whole scene with the #s of sequences, for FrameStore
        std::string error;
        int frame =
            0;  ///< of a sequence: the one in `part`        ///< why it can't be read, or ""
    };

    /// Starts to read; what is still being read is dropped.
    void open(const command::SceneInput& input);

    /// Returns what was read since the last call, if anything was.
    std::optional<Loaded> take();

    [[nodiscard]] bool loading() const { return task_.busy(); }
    /// The file that is being read and its size, in a few words.
    [[nodiscard]] std::string progress() const;
    /// What was last asked for.
    [[nodiscard]] const command::SceneInput& input() const { return input_; }

private:
    /// State shared with the thread, which may still run after another file was asked for.
    struct Shared {
        std::mutex lock;
        std::optional<Loaded> loaded;
        std::string progress;
    };
    static void publish(Shared& shared, Loaded loaded);
    static void set_progress(Shared& shared, const std::string& progress);
    static void read(const command::SceneInput& input, Shared& shared,
                     const Background::Stop& stop);
    static void read_vdb(const command::SceneInput& input, Shared& shared);
    static void read_scene(const command::SceneInput& input, Shared& shared,
                           const Background::Stop& stop);

    command::SceneInput input_;
    std::shared_ptr<Shared> shared_ = std::make_shared<Shared>();
    Background task_;
};

}  // namespace fumarole::window
