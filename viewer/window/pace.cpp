#include "window/pace.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace fumarole::window {

namespace {

// Each about 0.6 of the one before.
constexpr std::array<Effort, 8> kEfforts{{{1, 1, 1},
                                          {1, 0.75, 2},
                                          {0.75, 0.75, 2},
                                          {0.66, 0.5, 2},
                                          {0.5, 0.5, 2},
                                          {0.5, 0.5, 4},
                                          {0.33, 0.375, 4},
                                          {0.25, 0.25, 4}}};
constexpr int kLast = static_cast<int>(kEfforts.size()) - 1;

}  // namespace

Pace::Pace(bool slow) : live_{slow ? 4 : 1}, now_{live_} {}

int Pace::levels()
{
    return kLast + 1;
}

const Effort& Pace::effort() const
{
    return kEfforts[static_cast<std::size_t>(now_)];
}

Settings Pace::settings(const Settings& asked) const
{
    return settings_at(asked, effort(), content_moves_ && moving_);
}

void Pace::begin(Change change, double seconds)
{
    content_moves_ = change >= Change::frame || (content_moves_ && moving_);
    still_ = change != Change::none ? 0 : still_ + seconds;
    const bool was_moving = moving_;
    moving_ = still_ < rest_after;
    if (moving_)
        now_ = live_;
    else if (was_moving)
        now_ = std::max(0, now_ - 1);
    else
        now_ = std::max(0, now_ - 2);
}

void Pace::end(double ms)
{
    if (!moving_)
        return;
    if (ms > 2 * target_ms)
        live_ = std::min(kLast, live_ + 2);
    else if (ms > target_ms)
        live_ = std::min(kLast, live_ + 1);
    else if (ms < 0.5 * target_ms)
        live_ = std::max(0, live_ - 1);
}

Settings settings_at(const Settings& asked, const Effort& effort, bool content_changes)
{
    constexpr int kCoarseShadows = 24, kFieldFrames = 8;
    Settings s = asked;
    const auto fewer = [&](int n, int least) {
        return std::min(n, std::max(least, static_cast<int>(std::lround(n * effort.steps))));
    };
    s.steps = fewer(asked.steps, 8);
    s.slices = fewer(asked.slices, 16);
    // Where it is automatic it is half at least.
    const int chosen = asked.resolution == Settings::kAutomatic ? 2 : asked.resolution;
    if (effort.resolution > chosen)
        s.resolution = effort.resolution;
    if (content_changes) {
        const auto cap = [](int nodes, int most) {
            return nodes == Settings::kAutomatic ? most : std::min(nodes, most);
        };
        s.shadow_volume_size = cap(asked.shadow_volume_size, kCoarseShadows);
        s.field_fill = std::max(asked.field_fill, kFieldFrames);
    }
    return s;
}

}  // namespace fumarole::window
