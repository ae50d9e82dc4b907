#pragma once

#include "window/change.h"
#include <fumarole/settings.h>

namespace fumarole::window {

/// What a frame may cost, from all that was asked for (effort 0) to very little.
struct Effort {
    double scale = 1;    ///< pixels of the picture for one of the screen, along an edge
    double steps = 1;    ///< share of the steps and slices
    int resolution = 1;  ///< resolution of the march, which is at least this coarse
};

/// Holds frames to a time: while something moves the picture is drawn at the least loss that keeps
/// the pace; at rest it sharpens, a frame at a time, up to what was asked for, and is then
/// averaged.
class Pace {
public:
    /// @param slow starts with coarse frames: a rasteriser in software
    explicit Pace(bool slow);

    double target_ms = 33;
    double rest_after = 0.15;  ///< seconds without a change that make rest

    /// A frame is about to be drawn, `seconds` after the last one.
    void begin(Change change, double seconds);
    /// Takes the time that the frame took.
    void end(double ms);

    [[nodiscard]] bool moving() const { return moving_; }
    /// Whether it is drawn as asked for: frames may be averaged.
    [[nodiscard]] bool full() const { return now_ == 0; }
    [[nodiscard]] const Effort& effort() const;
    /// What was asked for, at this frame's effort.
    [[nodiscard]] Settings settings(const Settings& asked) const;
    [[nodiscard]] int level() const { return now_; }
    static int levels();

private:
    int live_;  ///< while something moves
    int now_;   ///< number for this frame
    bool moving_ = true;
    bool content_moves_ = false;  ///< what moves is more than the camera or a setting
    double still_ = 0;            ///< seconds since the last change
};

/// The settings of a frame at an effort. @param content_changes media or lights are being edited:
/// shadows in the media, which are filled anew each time, are coarse then, and other light is
/// filled over frames
Settings settings_at(const Settings& asked, const Effort& effort, bool content_changes);

}  // namespace fumarole::window
