#include "window/playback.h"

#include <algorithm>

namespace fumarole::window {

Playback::Playback(int first, int last, double frames_per_second_)
    : frames_per_second{frames_per_second_}, first_{first}, last_{last}, frame_{first}
{
}

void Playback::play(bool on)
{
    playing_ = on && moves();
    since_ = 0;
    if (playing_ && frame_ == last_ && !loop)
        frame_ = first_;
}

void Playback::scrub(int frame)
{
    frame_ = std::clamp(frame, first_, last_);
    since_ = 0;
}

bool Playback::act(Action action)
{
    switch (action) {
    case Action::play:
        play(!playing_);
        return true;
    case Action::frame_back:
        scrub(frame_ - 1);
        return true;
    case Action::frame_on:
        scrub(frame_ + 1);
        return true;
    case Action::first_frame:
        scrub(first_);
        return true;
    default:
        return false;
    }
}

void Playback::advance(double seconds, bool ready)
{
    if (!playing_ || !ready)
        return;
    since_ += seconds;
    const double each = 1 / frames_per_second;
    if (since_ < each)
        return;
    since_ = std::min(since_ - each, each);  // what is late stays late by a frame at most
    if (frame_ < last_)
        ++frame_;
    else if (loop)
        frame_ = first_;
    else
        playing_ = false;
}

}  // namespace fumarole::window
