#include "animation.h"

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

/// Slope at key i [1/s]: the mean of the chords' beside it, each weighing as the other is long,
/// which is the parabola's through three keys. At an end the chord itself.
glm::dvec3 slope(const std::vector<CameraKey>& path, std::size_t i, glm::dvec3 Camera::*what)
{
    const auto chord = [&](std::size_t a) {
        return (path[a + 1].camera.*what - path[a].camera.*what) /
               (path[a + 1].time - path[a].time);
    };
    if (i == 0)
        return chord(0);
    if (i + 1 == path.size())
        return chord(i - 1);
    const double before = path[i].time - path[i - 1].time, after = path[i + 1].time - path[i].time;
    return (after * chord(i - 1) + before * chord(i)) / (before + after);
}

}  // namespace

Camera camera_at(const std::vector<CameraKey>& path, double time)
{
    if (time <= path.front().time)
        return path.front().camera;
    if (time >= path.back().time)
        return path.back().camera;
    const auto next = std::upper_bound(path.begin(), path.end(), time,
                                       [](double t, const CameraKey& key) { return t < key.time; });
    const auto b = static_cast<std::size_t>(next - path.begin()), a = b - 1;
    const Camera &from = path[a].camera, &to = path[b].camera;
    const double h = path[b].time - path[a].time, u = (time - path[a].time) / h;
    const auto on_cubic = [&](glm::dvec3 Camera::*what) {
        const double u2 = u * u, u3 = u2 * u;
        return (2 * u3 - 3 * u2 + 1) * (from.*what) + (3 * u2 - 2 * u3) * (to.*what) +
               h * ((u3 - 2 * u2 + u) * slope(path, a, what) + (u3 - u2) * slope(path, b, what));
    };
    Camera camera = from;
    camera.position = on_cubic(&Camera::position);
    camera.look_at = on_cubic(&Camera::look_at);
    for (double Camera::*what :
         {&Camera::vfov_deg, &Camera::near, &Camera::far, &Camera::ortho_height})
        camera.*what = std::lerp(from.*what, to.*what, u);
    return camera;
}

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

bool same_content(const Scene& a, const Scene& b)
{
    const auto drifts = [](const Medium& medium) {
        const auto* box = std::get_if<BoxMedium>(&medium);
        const auto* noise = box != nullptr ? std::get_if<NoiseProfile>(&box->profile) : nullptr;
        return noise != nullptr && noise->drift != glm::dvec3(0);
    };
    return a.world == b.world && a.lights == b.lights && a.media == b.media &&
           a.surfaces == b.surfaces &&
           (a.time == b.time || std::none_of(a.media.begin(), a.media.end(), drifts));
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
