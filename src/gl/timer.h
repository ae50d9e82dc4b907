#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fumarole/timing.h>

#include "gl/device.h"

namespace fumarole::gl {

/// Milliseconds of each pass, in the order in which they first ran. A name that ran twice stands
/// once, with the sum.
using PassTimes = std::vector<std::pair<std::string, double>>;

/// The method whose times can be believed: queries, or, on a software rasteriser, finish.
Timing measuring_timing(const Device& device);

/// Times the passes of frames by name. Switched off it does nothing at all.
class PassTimers {
public:
    explicit PassTimers(const Device& device) : device_{device} {}
    ~PassTimers();
    PassTimers(const PassTimers&) = delete;
    PassTimers& operator=(const PassTimers&) = delete;

    /// Off forgets what is not taken yet.
    void set_timing(Timing timing);
    [[nodiscard]] Timing timing() const { return timing_; }

    /// Times what is drawn while it lives.
    class Scope {
    public:
        Scope(PassTimers& timers, std::string name);
        ~Scope();
        Scope(const Scope&) = delete;
        Scope& operator=(const Scope&) = delete;

    private:
        PassTimers& timers_;
        std::string name_;
        std::chrono::steady_clock::time_point begin_{};
        GLuint begin_query_ = 0;
    };
    [[nodiscard]] Scope scope(std::string name) { return {*this, std::move(name)}; }

    /// Ends a frame when it dies: the passes since the one before are its own.
    class FrameEnd {
    public:
        FrameEnd(PassTimers& timers, std::uint64_t index) : timers_{timers}, index_{index} {}
        ~FrameEnd() { timers_.end_frame(index_); }
        FrameEnd(const FrameEnd&) = delete;
        FrameEnd& operator=(const FrameEnd&) = delete;

    private:
        PassTimers& timers_;
        std::uint64_t index_;
    };
    /// @param index the frame's number, as FrameTimes gives it back
    [[nodiscard]] FrameEnd frame(std::uint64_t index) { return {*this, index}; }

    struct FrameTimes {
        std::uint64_t index = 0;
        PassTimes passes;
    };
    /// Of the last frame whose times are known; nothing if there is none since the last call. Never
    /// waits.
    std::optional<FrameTimes> take();

private:
    struct Queried {
        std::string name;
        GLuint begin = 0, end = 0;
    };
    struct Pending {
        std::uint64_t index = 0;
        std::vector<Queried> passes;
    };
    /// Frames that may be on their way to the GPU, and passes of one: what is more is not timed.
    static constexpr std::size_t kMostPending = 8, kMostPasses = 64;

    GLuint stamp();
    void end_frame(std::uint64_t index);
    void look();
    void drop();

    const Device& device_;
    Timing timing_ = Timing::off;
    FrameTimes current_;            ///< times of the current frame by glFinish
    std::vector<Queried> queried_;  ///< queries of the frame that is being drawn
    std::deque<Pending> pending_;   ///< the oldest first
    std::optional<FrameTimes> known_;
    std::vector<GLuint> spare_;  ///< queries that no pass uses now
};

}  // namespace fumarole::gl
