#pragma once

#include <chrono>
#include <optional>

#include "gl/device.h"
#include "gl/timer.h"

namespace fumarole::gl {

/// Times what it spans, the GPU's part too, where times are measured by waiting for it.
class Stopwatch {
public:
    Stopwatch(const Device& gl, const PassTimers& timers)
        : gl_{gl}, runs_{timers.timing() == Timing::finish}
    {
        if (runs_)
            gl_->Finish();
        begin_ = std::chrono::steady_clock::now();
    }
    /// Nothing where it was not measured.
    [[nodiscard]] std::optional<double> ms() const
    {
        if (!runs_)
            return std::nullopt;
        gl_->Finish();
        return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin_)
            .count();
    }

private:
    const Device& gl_;
    bool runs_;
    std::chrono::steady_clock::time_point begin_;
};

}  // namespace fumarole::gl
