#include "window/frame_store.h"

#include <algorithm>
#include <set>

#include "window/glfw_window.h"
#include <fumarole/asset/animation.h>
#include <fumarole/asset/frame_loader.h>

namespace fumarole::window {

FrameShelf::FrameShelf(int first, int last, std::uint64_t max_bytes)
    : first_{first}, count_{last - first + 1}, max_bytes_{max_bytes}, head_{first}
{
}

int FrameShelf::distance(int frame) const
{
    return (frame - head_ + count_) % count_;
}

void FrameShelf::put(int frame, Scene scene, std::uint64_t bytes)
{
    constexpr std::size_t kLeast = 2;
    largest_ = std::max(largest_, bytes);
    bytes_ += bytes;
    frames_[frame] = {std::move(scene), bytes};
    while (frames_.size() > kKept || (frames_.size() > kLeast && bytes_ > max_bytes_)) {
        const auto last =
            std::max_element(frames_.begin(), frames_.end(), [&](const auto& a, const auto& b) {
                return distance(a.first) < distance(b.first);
            });
        bytes_ -= last->second.bytes;
        frames_.erase(last);
    }
}

const Scene* FrameShelf::find(int frame) const
{
    const auto there = frames_.find(frame);
    return there == frames_.end() ? nullptr : &there->second.scene;
}

std::string FrameShelf::error(int frame) const
{
    const auto there = errors_.find(frame);
    return there == errors_.end() ? "" : there->second;
}

std::optional<int> FrameShelf::next() const
{
    std::uint64_t nearer = 0;
    for (int i = 0; i <= std::min(kAhead, count_ - 1); ++i) {
        const int frame = first_ + (head_ - first_ + i) % count_;
        if (const auto there = frames_.find(frame); there != frames_.end())
            nearer += there->second.bytes;
        else if (!errors_.contains(frame))
            return i <= 1 || nearer + largest_ <= max_bytes_ ? std::optional(frame) : std::nullopt;
    }
    return std::nullopt;
}

std::uint64_t frame_bytes(const Scene& scene, const Scene& frame)
{
    std::set<const VoxelGrid*> grids;
    for (std::size_t i = 0; i < scene.media.size(); ++i) {
        const auto* moving = std::get_if<GridMedium>(&scene.media[i]);
        if (moving == nullptr || !is_sequence(moving->file))
            continue;
        const auto& grid = std::get<GridMedium>(frame.media[i]);
        grids.insert(
            {grid.density.get(), grid.emission.get(), grid.color.get(), grid.temperature.get()});
    }
    grids.erase(nullptr);
    std::uint64_t bytes = 0;
    for (const VoxelGrid* grid : grids)
        bytes += grid->values.size() * sizeof(float) + grid->bricks.size() * sizeof(glm::ivec3) +
                 grid->tiles.size() * sizeof(VoxelTile);
    return bytes;
}

FrameStore::FrameStore(Scene scene, int first, int last, const Scene& like)
    : scene_{std::move(scene)}, like_{like}, shelf_{first, last, kMostBytes}, thread_{[this] {
          work();
      }}
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
        shelf_.move_to(frame);
        if (const Scene* there = shelf_.find(frame))
            scene = *there;
    }
    wanted_.notify_all();
    return scene;
}

std::string FrameStore::error(int frame) const
{
    const std::lock_guard lock(lock_);
    return shelf_.error(frame);
}

void FrameStore::forget_errors()
{
    {
        const std::lock_guard lock(lock_);
        shelf_.forget_errors();
    }
    wanted_.notify_all();
}

int FrameStore::frames_there() const
{
    const std::lock_guard lock(lock_);
    return static_cast<int>(shelf_.size());
}

void FrameStore::work()
{
    std::unique_lock lock(lock_);
    while (!stop_) {
        const std::optional<int> frame = shelf_.next();
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
        if (read) {
            like_ = *read;
            const std::uint64_t bytes = frame_bytes(scene_, *read);
            shelf_.put(*frame, std::move(*read), bytes);
        } else {
            shelf_.put_error(*frame, error);
        }
        GlfwWindow::wake();
    }
}

}  // namespace fumarole::window
