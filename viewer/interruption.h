#pragma once

#include <atomic>
#include <csignal>

namespace fumarole::command {

/// While one lives, the first SIGINT or SIGTERM only raises a flag, for work that asks it, as all
/// reading of files does; the same signal once more ends the program at once. One at a time.
class Interruption {
public:
    Interruption();
    ~Interruption();
    Interruption(const Interruption&) = delete;
    Interruption& operator=(const Interruption&) = delete;

    [[nodiscard]] static const std::atomic<bool>* flag();

private:
    struct sigaction int_ {
    }, term_{};  ///< as they were before
};

}  // namespace fumarole::command
