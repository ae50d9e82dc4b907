#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "window/frame_store.h"
#include "window/playback.h"
#include <fumarole/scene.h>

namespace fumarole::window {

/// First and last frame of a scene in time, or nothing for one that stands still.
/// @param moving with the #s of its sequences
std::optional<std::pair<int, int>> frames_in(const Scene& moving);

/// The frames of a scene in time: the playhead, the frame on the screen, and those read ahead.
class Sequence {
public:
    /// A scene that stands still.
    Sequence() = default;
    /// @param moving with the #s of its sequences @param like the scene of frame `shown`
    /// @param hold_missing whether what is shown stays, and playing goes on, where a frame is
    /// missing or broken
    Sequence(Scene moving, const Scene& like, int shown, bool hold_missing);

    [[nodiscard]] bool moves() const { return store_ != nullptr; }
    /// Whether the playhead's frame is still being read.
    [[nodiscard]] bool waits() const { return playback_.frame() != shown_; }
    [[nodiscard]] int shown() const { return shown_; }
    [[nodiscard]] int frames_there() const { return store_ ? store_->frames_there() : 0; }
    [[nodiscard]] Playback& playback() { return playback_; }
    [[nodiscard]] const Playback& playback() const { return playback_; }

    /// Moves the playhead by the time that went by. Returns the playhead's frame once it is read,
    /// if it is another than the one shown.
    /// @throws Error if that frame can't be read and is not held; the playhead is back at the one
    /// shown then
    std::optional<Scene> advance(double seconds);

private:
    Playback playback_;
    std::unique_ptr<FrameStore> store_;
    int shown_ = 0;
    bool hold_missing_ = false;
};

}  // namespace fumarole::window
