#pragma once

#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>

#include "scene.h"

namespace fumarole::window {

/// The frames of a scene in time, read ahead of the playhead on a thread of its own and kept while
/// they may be needed again.
class FrameStore {
public:
    static constexpr int kAhead = 8;  ///< frames that are read before they are asked for
    static constexpr int kKept = 24;

    /// @param scene with the #s of its sequences @param like what was read already
    FrameStore(Scene scene, int first, int last, const Scene& like);
    ~FrameStore();
    FrameStore(const FrameStore&) = delete;
    FrameStore& operator=(const FrameStore&) = delete;

    /// Puts the playhead. @returns the frame's scene if it is there by now
    std::optional<Scene> at(int frame);
    /// Why a frame can't be had, or "".
    [[nodiscard]] std::string error(int frame) const;
    /// Gives a frame that could not be read another try.
    void forget_errors();
    [[nodiscard]] int frames_there() const;

private:
    void work();
    std::optional<int> next() const;

    const Scene scene_;
    const int first_, last_;
    mutable std::mutex lock_;
    std::condition_variable wanted_;
    int head_;
    bool stop_ = false;
    Scene like_;
    std::map<int, Scene> frames_;
    std::map<int, std::string> errors_;
    std::thread thread_;
};

}  // namespace fumarole::window
