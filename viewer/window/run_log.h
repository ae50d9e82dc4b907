#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "window/reference_view.h"

namespace fumarole::window {

/// What a run did, for machines.
struct AppReport {
    int frames = 0;
    double first_frame_ms = 0;    ///< until the window first showed something
    double first_picture_ms = 0;  ///< until it first showed a whole scene, 0 if never
    double settled_ms = 0;        ///< until that was as sharp as it gets, 0 if never
    std::string device;
    std::string message;             ///< that stood in the window at the end
    std::string plan;                ///< what the last plan chose; "" if there was none
    std::vector<std::string> notes;  ///< of what the library said, each once
    /// What the media's grids are taken for at the end, and what the browser shows if it is open.
    struct Grid {
        std::size_t medium = 0;
        std::string name, type, role, error;
        std::uint64_t voxels = 0;
    };
    struct File {
        std::string name, error;
        int frames = 0;
        bool picture = false;
    };
    std::vector<Grid> grids;
    std::vector<File> files;
    std::vector<ErrorFigures> errors;  ///< against the reference, at the end
};

/// The run's clock, and the moments that the report tells of.
class RunLog {
public:
    explicit RunLog(std::string device) { report_.device = std::move(device); }

    /// Seconds since the start.
    [[nodiscard]] double now() const
    {
        return std::chrono::duration<double>(Clock::now() - begin_).count();
    }
    /// Begins a frame. Returns the seconds since the last one began.
    double begin_frame();
    /// A frame is over. @param picture true if it showed a whole scene
    void end_frame(bool picture, bool settled);
    void note(const std::string& line);
    /// A frame was over at once: a minimised window shows nothing.
    void skip_frame() { ++report_.frames; }

    [[nodiscard]] const AppReport& report() const { return report_; }

private:
    using Clock = std::chrono::steady_clock;

    Clock::time_point begin_ = Clock::now();
    double frame_begin_ = 0;  ///< [s] since the start
    AppReport report_;
};

}  // namespace fumarole::window
