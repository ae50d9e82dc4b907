#include <fumarole/asset/animation.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <system_error>

namespace fumarole {

namespace fs = std::filesystem;

namespace {

/// Where a name has a frame's number.
struct Place {
    std::size_t begin, length;
    int digits;
};

bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/// The last run of `sign`s.
std::optional<Place> find_run(const std::string& name, char sign)
{
    const std::size_t last = name.find_last_of(sign);
    if (last == std::string::npos)
        return std::nullopt;
    const std::size_t before = name.find_last_not_of(sign, last);
    const std::size_t first = before == std::string::npos ? 0 : before + 1;
    return Place{first, last - first + 1, static_cast<int>(last - first + 1)};
}

/// The last `head` with a number of digits or none behind it, and then `tail`.
std::optional<Place> find_word(const std::string& name, std::string_view head,
                               std::string_view tail)
{
    constexpr std::size_t kMostDigits = 3;  // of a number of digits: no name has room for more
    for (std::size_t at = name.rfind(head); at != std::string::npos;
         at = at == 0 ? std::string::npos : name.rfind(head, at - 1)) {
        const std::size_t begin = at + head.size();
        std::size_t end = begin;
        while (end < name.size() && is_digit(name[end]))
            ++end;
        if (end - begin > kMostDigits || name.compare(end, tail.size(), tail) != 0)
            continue;
        int digits = 1;
        std::from_chars(name.data() + begin, name.data() + end, digits);
        return Place{at, end + tail.size() - at, std::max(digits, 1)};
    }
    return std::nullopt;
}

std::optional<Place> find_place(const std::string& name)
{
    std::optional<Place> place = find_run(name, '#');
    if (!place)
        place = find_word(name, "%", "d");
    if (!place)
        place = find_word(name, "${F", "}");
    if (!place)
        place = find_word(name, "$F", "");
    if (!place)
        place = find_run(name, '@');
    return place;
}

fs::path numbered(const fs::path& file, int frame, int more_digits)
{
    std::string name = file.filename().string();
    const std::optional<Place> place = find_place(name);
    if (!place)
        return file;
    name.replace(place->begin, place->length,
                 fmt::format("{:0{}}", frame, place->digits + more_digits));
    return file.parent_path() / name;
}

/// Minus signs stand beside the digits in some programs, and take the place of one in others.
int more_digits_of(int frame)
{
    return frame < 0 ? 1 : 0;
}

}  // namespace

bool has_frame_number(const fs::path& file)
{
    return find_place(file.filename().string()).has_value();
}

fs::path numbered_file(const fs::path& file, int frame)
{
    return numbered(file, frame, 0);
}

bool is_sequence(const fs::path& file)
{
    std::error_code unknown;
    return has_frame_number(file) && !fs::exists(file, unknown);
}

fs::path frame_file(const fs::path& file, int frame)
{
    if (!is_sequence(file))
        return file;
    const fs::path usual = numbered(file, frame, 0),
                   other = numbered(file, frame, more_digits_of(frame));
    std::error_code unknown;
    return usual != other && !fs::exists(usual, unknown) && fs::exists(other, unknown) ? other
                                                                                       : usual;
}

std::vector<int> frames_of(const fs::path& sequence)
{
    const std::string name = sequence.filename().string();
    const std::optional<Place> place = find_place(name);
    if (!place)
        return {};
    const std::string_view head = std::string_view(name).substr(0, place->begin),
                           tail = std::string_view(name).substr(place->begin + place->length);
    const fs::path folder = sequence.has_parent_path() ? sequence.parent_path() : fs::path(".");
    std::vector<int> frames;
    std::error_code error;
    for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
        const std::string other = at->path().filename().string();
        if (other.size() <= head.size() + tail.size() || !other.starts_with(head) ||
            !other.ends_with(tail))
            continue;
        const char* begin = other.data() + head.size();
        const char* stop = other.data() + other.size() - tail.size();
        int frame = 0;
        const auto parsed = std::from_chars(begin, stop, frame);
        if (parsed.ec == std::errc{} && parsed.ptr == stop &&
            (numbered(sequence, frame, 0).filename() == other ||
             numbered(sequence, frame, more_digits_of(frame)).filename() == other))
            frames.push_back(frame);
    }
    std::sort(frames.begin(), frames.end());
    frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
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
        grid->density = grid->emission = grid->color = grid->temperature = nullptr;
    }
    for (Transparent& transparent : now.transparents) {
        TransparentLook& look = look_of(transparent);
        if (!is_sequence(look.image_file))
            continue;
        look.image_file = frame_file(look.image_file, frame).string();
        look.image = nullptr;
    }
    return now;
}

}  // namespace fumarole
