#include "progress.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fmt/format.h>
#include <unistd.h>

namespace fumarole::command {

namespace {

constexpr int kLine = 78;  ///< columns; a longer one would wrap and not be drawn over
constexpr int kBar = 24;

std::string bar(std::string_view what, double share)
{
    share = std::clamp(share, 0.0, 1.0);
    const int full = static_cast<int>(share * kBar);
    return fmt::format("{} [{:#<{}}{:-<{}}] {:3.0f} %", what, "", full, "", kBar - full,
                       100 * share);
}

}  // namespace

std::string duration(double seconds)
{
    const auto s = std::lround(seconds);
    return s < 90 ? fmt::format("{} s", s) : fmt::format("{} min {:02} s", s / 60, s % 60);
}

void print_over_progress(std::string_view line)
{
    if (isatty(STDERR_FILENO) != 0)
        fmt::print(stderr, "\r{:{}}\r", "", kLine);
    fmt::print(stderr, "fumarole: {}\n", line);
}

Progress::Progress() : on_{isatty(STDERR_FILENO) != 0} {}

Progress::~Progress()
{
    clear();
}

void Progress::show(std::string_view what, double share)
{
    const Clock::time_point now = Clock::now();
    if (what != what_) {
        what_ = what;
        begin_ = now;
        first_share_ = share;
    }
    if (!due())
        return;
    std::string text = bar(what, share);
    if (share > first_share_) {
        const double seconds = std::chrono::duration<double>(now - begin_).count();
        text += fmt::format(", about {} left",
                            duration(seconds * (1 - share) / (share - first_share_)));
    }
    draw(text);
}

void Progress::show(std::string_view what, double share, double seconds_left)
{
    if (due())
        draw(fmt::format("{}, about {} left", bar(what, share), duration(seconds_left)));
}

void Progress::show(std::string_view what)
{
    if (due())
        draw(std::string(what));
}

void Progress::clear()
{
    if (shown_)
        fmt::print(stderr, "\r{:{}}\r", "", kLine);
    shown_ = false;
}

bool Progress::due()
{
    return on_ && Clock::now() - last_ >= std::chrono::milliseconds(200);
}

void Progress::draw(const std::string& text)
{
    last_ = Clock::now();
    fmt::print(stderr, "\r{:<{}.{}}", text, kLine, kLine);
    std::fflush(stderr);
    shown_ = true;
}

}  // namespace fumarole::command
