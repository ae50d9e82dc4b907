#include "window/sequence.h"

#include <algorithm>
#include <cmath>

#include <fumarole/asset/animation.h>
#include <fumarole/errors.h>

namespace fumarole::window {

std::optional<std::pair<int, int>> frames_in(const Scene& moving)
{
    std::optional<std::pair<int, int>> range;
    for (const Medium& medium : moving.media) {
        const auto* grid = std::get_if<GridMedium>(&medium);
        if (grid == nullptr || !is_sequence(grid->file))
            continue;
        const std::vector<int> frames = frames_of(grid->file);
        if (frames.empty())
            continue;
        if (!range)
            range = {frames.front(), frames.back()};
        range->first = std::min(range->first, frames.front());
        range->second = std::max(range->second, frames.back());
    }
    if (!range && moving.camera_path.size() > 1)
        range = {0, static_cast<int>(std::ceil((moving.camera_path.back().time - moving.time) *
                                               moving.frames_per_second))};
    return range && range->second > range->first ? range : std::nullopt;
}

Sequence::Sequence(Scene moving, const Scene& like, int shown, bool hold_missing)
    : hold_missing_{hold_missing}
{
    const auto range = frames_in(moving);
    if (!range)
        return;
    playback_ = Playback(range->first, range->second, moving.frames_per_second);
    playback_.scrub(shown);
    shown_ = playback_.frame();
    store_ = std::make_unique<FrameStore>(std::move(moving), range->first, range->second, like);
}

std::optional<Scene> Sequence::advance(double seconds)
{
    if (!store_)
        return std::nullopt;
    playback_.advance(seconds, !waits());
    const int wanted = playback_.frame();
    std::optional<Scene> frame = store_->at(wanted);
    if (wanted == shown_)
        return std::nullopt;
    if (const std::string error = store_->error(wanted); !error.empty()) {
        if (hold_missing_) {
            shown_ = wanted;
            return std::nullopt;
        }
        playback_.play(false);
        playback_.scrub(shown_);
        store_->forget_errors();
        throw Error(error);
    }
    if (frame)
        shown_ = wanted;
    return frame;
}

}  // namespace fumarole::window
