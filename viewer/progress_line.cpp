#include "progress_line.h"

#include <cstdio>
#include <fmt/format.h>
#include <unistd.h>

namespace fumarole::command {

std::string duration_text(double seconds)
{
    const int s = static_cast<int>(seconds + 0.5);
    return s < 90 ? fmt::format("{} s", s) : fmt::format("{} min {:02} s", s / 60, s % 60);
}

ProgressLine::ProgressLine() : on_{isatty(STDERR_FILENO) != 0} {}

void ProgressLine::show(const std::string& text)
{
    const auto now = std::chrono::steady_clock::now();
    if (!on_ || now - last_ < std::chrono::milliseconds(200))
        return;
    last_ = now;
    fmt::print(stderr, "\r{:<72}", text);
    std::fflush(stderr);
    shown_ = true;
}

void ProgressLine::clear()
{
    if (shown_)
        fmt::print(stderr, "\r{:72}\r", "");
    shown_ = false;
}

}  // namespace fumarole::command
