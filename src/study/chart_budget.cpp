#include "study/chart_budget.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <limits>
#include <mutex>
#include <thread>

#include "study/seconds.h"

namespace fumarole::study {

namespace {

using Clock = std::chrono::steady_clock;

/// A flag that goes up with another one, or when time is up: a reference that is being prepared
/// reports nothing, so nobody else could raise it.
class TimedCancel {
public:
    TimedCancel(double seconds, const std::atomic<bool>* other)
        : raised_{other != nullptr && *other}, watch_{[this, seconds,
                                                       other](const std::stop_token& over) {
              const Clock::time_point begin = Clock::now();
              std::unique_lock lock(mutex_);
              while (!over.stop_requested() && !raised_) {
                  wake_.wait_for(lock, over, std::chrono::milliseconds(50), [] { return false; });
                  raised_ = seconds_since(begin) > seconds || (other != nullptr && *other);
              }
          }}
    {
    }

    [[nodiscard]] const std::atomic<bool>* flag() const { return &raised_; }

private:
    std::atomic<bool> raised_;
    std::mutex mutex_;
    std::condition_variable_any wake_;
    std::jthread watch_;  // last: it ends before what it uses
};

}  // namespace

double looser(double tolerance, int bounces)
{
    return std::min((bounces > 0 ? 2 : 4) * tolerance,
                    std::max(tolerance, loosest_tolerance(bounces)));
}

double guess_reference_seconds(const Scene& scene, const ReferenceOptions& options, double patience)
{
    Scene small = scene;
    small.resolution = glm::max(scene.resolution / 8u, glm::uvec2(1));
    ReferenceOptions pilot = options;
    pilot.region.reset();
    const Clock::time_point begin = Clock::now();
    double prepared = -1;  // what comes before the first pixels costs the same at any size
    pilot.progress = [&](double) {
        if (prepared < 0)
            prepared = seconds_since(begin);
    };
    const TimedCancel cancel(patience, options.cancel);
    pilot.cancel = cancel.flag();
    try {
        render_reference(small, pilot);
    } catch (const ReferenceCancelled&) {
        if (options.cancel != nullptr && *options.cancel)
            throw;
        return std::numeric_limits<double>::infinity();
    }
    const auto pixels = [](glm::uvec2 size) { return static_cast<double>(size.x) * size.y; };
    return prepared +
           (seconds_since(begin) - prepared) * pixels(scene.resolution) / pixels(small.resolution);
}

double fit_tolerance(const Scene& scene, const ReferenceOptions& options, double seconds)
{
    ReferenceOptions tried = options;
    while (tried.tolerance < loosest_tolerance(tried.most_bounces()) &&
           guess_reference_seconds(scene, tried, seconds / 8) > seconds)
        tried.tolerance = looser(tried.tolerance, tried.most_bounces());
    return tried.tolerance;
}

}  // namespace fumarole::study
