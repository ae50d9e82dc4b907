#pragma once

#include <condition_variable>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include <fumarole/scene.h>

namespace fumarole::window {

/// Which frames of a loop are kept, and which is read next. The one that is shown and the one after
/// it are always wanted; more of them as long as they fit.
class FrameShelf {
public:
    static constexpr int kAhead = 8;  ///< frames that are read before they are asked for
    static constexpr std::size_t kKept = 24;

    FrameShelf(int first, int last, std::uint64_t max_bytes);

    void move_to(int frame) { head_ = frame; }
    /// Keeps a frame, and lets go of those that are needed last.
    void put(int frame, Scene scene, std::uint64_t bytes);
    void put_error(int frame, const std::string& error) { errors_[frame] = error; }
    void forget_errors() { errors_.clear(); }

    [[nodiscard]] const Scene* find(int frame) const;
    /// Why a frame can't be had, or "".
    [[nodiscard]] std::string error(int frame) const;
    [[nodiscard]] std::size_t size() const { return frames_.size(); }

    /// The nearest one from the playhead on, round the end, that is not there and will stay once it
    /// is, those before it being as large as they are.
    [[nodiscard]] std::optional<int> next() const;

private:
    struct Kept {
        Scene scene;
        std::uint64_t bytes = 0;
    };
    /// Frames from the playhead on, round the end.
    [[nodiscard]] int distance(int frame) const;

    const int first_, count_;
    const std::uint64_t max_bytes_;
    int head_;
    std::uint64_t bytes_ = 0;  ///< bytes of the frames that are there
    std::uint64_t largest_ =
        0;  ///< bytes of the largest frame so far, for which one that was not read is taken
    std::map<int, Kept> frames_;
    std::map<int, std::string> errors_;
};

/// Bytes of the grids that a frame has of its own. @param scene with the #s of its sequences
std::uint64_t frame_bytes(const Scene& scene, const Scene& frame);

/// The frames of a scene in time, read ahead of the playhead on a thread of its own and kept while
/// they may be needed again.
class FrameStore {
public:
    /// Of grids on the CPU; while one more frame is read it comes on top.
    static constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 30;

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

    const Scene scene_;
    mutable std::mutex lock_;
    std::condition_variable wanted_;
    bool stop_ = false;
    Scene like_;
    FrameShelf shelf_;
    std::thread thread_;
};

}  // namespace fumarole::window
