#pragma once

#include "window/keys.h"

namespace fumarole::window {

/// A playhead over the frames of a scene in time.
class Playback {
public:
    Playback() = default;
    Playback(int first, int last, double frames_per_second);

    [[nodiscard]] bool moves() const { return last_ > first_; }
    [[nodiscard]] int first() const { return first_; }
    [[nodiscard]] int last() const { return last_; }
    [[nodiscard]] int frame() const { return frame_; }
    [[nodiscard]] bool playing() const { return playing_; }

    void play(bool on);
    void scrub(int frame);  ///< held within the range

    /// Does what an action does to the playhead. Returns false if it is about something else.
    bool act(Action action);

    /// Moves on by the time that went by. Stays where it is while its frame is not `ready`: frames
    /// are shown late rather than skipped.
    void advance(double seconds, bool ready);

    double frames_per_second = 24;
    bool loop = true;

private:
    int first_ = 0, last_ = 0, frame_ = 0;
    bool playing_ = false;
    double since_ = 0;  ///< seconds that the frame has been shown
};

}  // namespace fumarole::window
