#pragma once

#include <chrono>
#include <string>
#include <string_view>

namespace fumarole::command {

/// `42 s`, `3 min 05 s`.
std::string duration(double seconds);

/// A line of the program's on stderr, where on a terminal a bar may stand: that goes, and is back
/// when it is next drawn.
void print_over_progress(std::string_view line);

/// A bar on the terminal that is drawn over as work goes on, and wiped at the end; nothing where
/// stderr is no terminal. Not for several threads at a time.
class Progress {
public:
    Progress();
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    /// @param what the work, in a few words; with other words the clock starts anew
    /// @param share that is done, 0..1; the time left follows from its pace
    void show(std::string_view what, double share);
    /// Where the time left [s] is known better than by the pace.
    void show(std::string_view what, double share, double seconds_left);
    /// Work of which nobody knows how long it takes.
    void show(std::string_view what);
    void clear();

private:
    using Clock = std::chrono::steady_clock;

    /// Is it time to draw again? Five times a second is enough.
    bool due();
    void draw(const std::string& text);

    bool on_, shown_ = false;
    Clock::time_point last_{};
    std::string what_;
    Clock::time_point begin_{};  ///< time of this work's first share
    double first_share_ = 0;
};

}  // namespace fumarole::command
