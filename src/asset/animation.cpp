#include <fumarole/asset/animation.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <system_error>

namespace fumarole {

namespace fs = std::filesystem;

namespace {

/// The last run of #s in a name: where it begins and how long it is.
std::pair<std::size_t, std::size_t> hashes(const std::string& name)
{
    const std::size_t last = name.find_last_of('#');
    if (last == std::string::npos)
        return {0, 0};
    const std::size_t before = name.find_last_not_of('#', last);
    const std::size_t first = before == std::string::npos ? 0 : before + 1;
    return {first, last - first + 1};
}

}  // namespace

bool is_sequence(const fs::path& file)
{
    return hashes(file.filename().string()).second > 0;
}

fs::path frame_file(const fs::path& file, int frame)
{
    std::string name = file.filename().string();
    const auto [first, length] = hashes(name);
    if (length == 0)
        return file;
    name.replace(first, length, fmt::format("{:0{}}", frame, length));
    return file.parent_path() / name;
}

std::vector<int> frames_of(const fs::path& sequence)
{
    const std::string name = sequence.filename().string();
    const auto [first, length] = hashes(name);
    const std::string_view head = std::string_view(name).substr(0, first),
                           tail = std::string_view(name).substr(first + length);
    const fs::path folder = sequence.has_parent_path() ? sequence.parent_path() : fs::path(".");
    std::vector<int> frames;
    std::error_code error;
    for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
        const std::string other = at->path().filename().string();
        if (other.size() < name.size() || !other.starts_with(head) || !other.ends_with(tail))
            continue;
        const char* begin = other.data() + head.size();
        const char* stop = other.data() + other.size() - tail.size();
        int frame = 0;
        const auto parsed = std::from_chars(begin, stop, frame);
        if (parsed.ec == std::errc{} && parsed.ptr == stop &&
            frame_file(sequence, frame).filename() == other)
            frames.push_back(frame);
    }
    std::sort(frames.begin(), frames.end());
    return frames;
}

Scene scene_at(const Scene& scene, int frame)
{
    Scene now = scene;
    now.time = scene.time + frame / scene.frames_per_second;
    if (!scene.camera_path.empty())
        now.camera = camera_at(scene.camera_path, now.time);
    for (Medium& medium : now.media) {
        auto* grid = std::get_if<GridMedium>(&medium);
        if (grid == nullptr || !is_sequence(grid->file))
            continue;
        grid->file = frame_file(grid->file, frame).string();
        grid->density = grid->emission = grid->color = nullptr;
    }
    return now;
}

std::optional<int> first_frame(const Scene& scene)
{
    for (const Medium& medium : scene.media) {
        const auto* grid = std::get_if<GridMedium>(&medium);
        if (grid == nullptr || !is_sequence(grid->file))
            continue;
        const std::vector<int> frames = frames_of(grid->file);
        return frames.empty() ? 1 : frames.front();
    }
    return std::nullopt;
}

}  // namespace fumarole
