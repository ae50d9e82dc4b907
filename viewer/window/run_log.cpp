#include "window/run_log.h"

#include <algorithm>

namespace fumarole::window {

double RunLog::begin_frame()
{
    const double time = now(), seconds = time - frame_begin_;
    frame_begin_ = time;
    return seconds;
}

void RunLog::end_frame(bool picture, bool settled)
{
    const double ms = 1e3 * now();
    if (++report_.frames == 1)
        report_.first_frame_ms = ms;
    if (report_.first_picture_ms == 0 && picture)
        report_.first_picture_ms = ms;
    if (report_.settled_ms == 0 && settled)
        report_.settled_ms = ms;
}

void RunLog::note(const std::string& line)
{
    std::vector<std::string>& notes = report_.notes;
    if (std::find(notes.begin(), notes.end(), line) == notes.end())
        notes.push_back(line);
}

}  // namespace fumarole::window
