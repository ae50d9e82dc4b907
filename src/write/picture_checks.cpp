#include "write/picture_checks.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <set>

#include <fumarole/errors.h>

namespace fumarole::write {

namespace fs = std::filesystem;

std::string channel_names(const std::vector<std::string>& channels)
{
    return channels.empty() ? "none" : fmt::format("'{}'", fmt::join(channels, "', '"));
}

void check_shape(const Image& image, const fs::path& file)
{
    assert(image.width >= 0 && image.height >= 0 &&
           image.pixels.size() == static_cast<std::size_t>(image.width) *
                                      static_cast<std::size_t>(image.height) *
                                      image.channels.size());
    if (image.pixels.empty()) {
        throw Error(fmt::format("{}: the picture is empty ({} x {} pixels, {} channels); give it a "
                                "size and a channel",
                                file.string(), image.width, image.height, image.channels.size()));
    }
    std::set<std::string_view> seen;
    for (const std::string& name : image.channels) {
        // EXR keeps one channel per name and OIIO would invent a name for an empty one.
        if (name.empty() || !seen.insert(name).second) {
            throw Error(fmt::format("{}: channel name '{}' is {}; give each channel its own name",
                                    file.string(), name, name.empty() ? "empty" : "used twice"));
        }
    }
}

void check_finite(const Image& image, std::span<const int> channels, const fs::path& file)
{
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            for (const int c : channels) {
                const float value = image.at(x, y, c);
                if (!std::isfinite(value)) {
                    throw Error(fmt::format(
                        "{}: channel '{}' is {} at pixel ({}, {}), nothing was written; look "
                        "there for the light or density that is out of range",
                        file.string(), image.channels[static_cast<std::size_t>(c)],
                        std::isnan(value) ? "NaN" : "infinite", x, y));
                }
            }
        }
    }
}

std::optional<int> find_channel(const std::vector<std::string>& channels, std::string_view name)
{
    const auto found = std::find(channels.begin(), channels.end(), name);
    if (found == channels.end()) {
        return std::nullopt;
    }
    return static_cast<int>(found - channels.begin());
}

}  // namespace fumarole::write
