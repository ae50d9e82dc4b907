#pragma once

#include <chrono>
#include <string>

namespace fumarole::command {

/// `42 s`, `3 min 05 s`.
std::string duration_text(double seconds);

/// A line on stderr that is written over, five times a second at most; nothing where stderr is no
/// terminal.
class ProgressLine {
public:
    ProgressLine();
    ~ProgressLine() { clear(); }
    ProgressLine(const ProgressLine&) = delete;
    ProgressLine& operator=(const ProgressLine&) = delete;

    void show(const std::string& text);
    void clear();

private:
    bool on_ = false, shown_ = false;
    std::chrono::steady_clock::time_point last_{};
};

}  // namespace fumarole::command
