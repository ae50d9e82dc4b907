#pragma once

#include <atomic>
#include <functional>
#include <list>
#include <memory>
#include <thread>

namespace fumarole::window {

/// One task at a time on a thread of its own. One that is no longer wanted is told to stop and not
/// waited for, but at the end: a window must not stand still for a file.
class Background {
public:
    using Stop = std::atomic<bool>;

    Background() = default;
    ~Background();
    Background(const Background&) = delete;
    Background& operator=(const Background&) = delete;

    /// Starts a task, which must not throw; tells the one before to stop.
    void run(std::function<void(const Stop&)> task);
    void stop();
    /// Whether the last task still runs and was not told to stop.
    [[nodiscard]] bool busy() const;

private:
    struct Job {
        std::shared_ptr<Stop> stop, done;
        std::thread thread;
    };
    void reap(bool all);

    std::list<Job> jobs_;  ///< the last one is the one that is wanted
};

}  // namespace fumarole::window
