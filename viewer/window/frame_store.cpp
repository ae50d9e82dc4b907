#include "window/frame_store.h"

#include <algorithm>

#include "asset/frame_loader.h"
#include "window/glfw_window.h"

namespace fumarole::window {

FrameStore::FrameStore(Scene scene, int first, int last, const Scene& like)
    : scene_{std::move(scene)}, first_{first}, last_{last}, head_{first}, like_{like},
      thread_{[this] { work(); }}
{
}

FrameStore::~FrameStore()
{
    {
        const std::lock_guard lock(lock_);
        stop_ = true;
    }
    wanted_.notify_all();
    thread_.join();
}

std::optional<Scene> FrameStore::at(int frame)
{
    std::optional<Scene> scene;
    {
        const std::lock_guard lock(lock_);
        head_ = frame;
        if (const auto there = frames_.find(frame); there != frames_.end())
            scene = there->second;
    }
    wanted_.notify_all();
    return scene;
}

std::string FrameStore::error(int frame) const
{
    const std::lock_guard lock(lock_);
    const auto there = errors_.find(frame);
    return there == errors_.end() ? "" : there->second;
}

void FrameStore::forget_errors()
{
    {
        const std::lock_guard lock(lock_);
        errors_.clear();
    }
    wanted_.notify_all();
}

int FrameStore::frames_there() const
{
    const std::lock_guard lock(lock_);
    return static_cast<int>(frames_.size());
}

/// The nearest one from the playhead on, round the end, that is not there.
std::optional<int> FrameStore::next() const
{
    const int all = last_ - first_ + 1;
    for (int i = 0; i <= std::min(kAhead, all - 1); ++i) {
        const int frame = first_ + (head_ - first_ + i) % all;
        if (!frames_.contains(frame) && !errors_.contains(frame))
            return frame;
    }
    return std::nullopt;
}

void FrameStore::work()
{
    std::unique_lock lock(lock_);
    while (!stop_) {
        const std::optional<int> frame = next();
        if (!frame) {
            wanted_.wait(lock);
            continue;
        }
        const Scene like = like_;
        lock.unlock();
        std::optional<Scene> read;
        std::string error;
        try {
            read = asset::load_frame(scene_, *frame, like).scene;
        } catch (const std::exception& failed) {
            error = failed.what();
        }
        lock.lock();
        if (!read) {
            errors_[*frame] = error;
        } else {
            like_ = *read;
            frames_[*frame] = std::move(*read);
            const int all = last_ - first_ + 1;
            while (frames_.size() > kKept) {  // the one that is needed last goes
                const auto distance = [&](int f) { return (f - head_ + all) % all; };
                frames_.erase(std::max_element(frames_.begin(), frames_.end(),
                                               [&](const auto& a, const auto& b) {
                                                   return distance(a.first) < distance(b.first);
                                               }));
            }
        }
        GlfwWindow::wake();
    }
}

}  // namespace fumarole::window
