#pragma once

#include <atomic>
#include <csignal>
#include <optional>

namespace fumarole::command {

/// While one lives, the first SIGINT or SIGTERM only raises a flag, for work that asks it, as all
/// reading of files does; the same signal once more ends the program at once. So does a time limit
/// that runs out. One at a time.
class Interruption {
public:
    /// @param time_limit seconds until the flag is raised all the same; none: it is not
    explicit Interruption(std::optional<double> time_limit = {});
    ~Interruption();
    Interruption(const Interruption&) = delete;
    Interruption& operator=(const Interruption&) = delete;

    [[nodiscard]] static const std::atomic<bool>* flag();
    /// Was it the time limit that raised the flag?
    [[nodiscard]] static bool timed_out();

private:
    struct sigaction int_ {
    }, term_{}, alarm_{};  ///< as they were before
};

}  // namespace fumarole::command
