#include "asset/grid_names.h"

#include <algorithm>
#include <cctype>

namespace fumarole::asset {

namespace {

constexpr std::array<std::string_view, 8> kFog{"density", "smoke", "soot",  "fog",
                                               "cloud",   "dust",  "steam", "mist"};
// What burns shows more of a volume than what only helps to compute it.
constexpr std::array<std::string_view, 14> kFire{
    "temperature", "temp",    "heat",  "flame",    "flames",   "fire",      "fuel",
    "burn",        "burning", "react", "emission", "emissive", "blackbody", "kelvin"};
constexpr std::array<std::string_view, 24> kNoFog{
    "shadow",    "distance",  "sdf",      "velocity", "vel", "v",        "pressure", "divergence",
    "vorticity", "collision", "collider", "mask",     "age", "id",       "rest",     "cd",
    "color",     "colour",    "rgb",      "albedo",   "uv",  "gradient", "curl",     "force"};

char lower(char c)
{
    return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
}

bool is_upper(char c)
{
    return std::isupper(static_cast<unsigned char>(c)) != 0;
}

bool is_letter(char c)
{
    return std::isalpha(static_cast<unsigned char>(c)) != 0;
}

/// The words of a name in lower case: of `smokeDensity_low.2` smoke, density, low.
std::vector<std::string> words_of(std::string_view name)
{
    std::vector<std::string> words;
    char before = 0;
    for (const char c : name) {
        if (is_letter(c)) {
            if (!is_letter(before) || (is_upper(c) && !is_upper(before)))
                words.emplace_back();
            words.back() += lower(c);
        }
        before = c;
    }
    return words;
}

template <std::size_t N>
std::optional<int> place_in(const std::array<std::string_view, N>& names,
                            const std::vector<std::string>& words)
{
    for (std::size_t i = 0; i < N; ++i)
        if (std::find(words.begin(), words.end(), names[i]) != words.end())
            return static_cast<int>(i);
    return std::nullopt;
}

/// Ranks of grids as fog.
namespace rank {
constexpr int kExact = 0, kWithin = 100, kUnknown = 200, kLevelSet = 300, kHot = 400, kNone = 500;
}  // namespace rank

}  // namespace

std::string lower_case(std::string_view text)
{
    std::string result(text);
    std::transform(result.begin(), result.end(), result.begin(), lower);
    return result;
}

std::string_view without_number(std::string_view address)
{
    return address.substr(0, address.find('['));
}

int fog_rank(std::string_view name, std::string_view grid_class)
{
    const bool level_set = grid_class == "level set";
    const std::string whole = lower_case(name);
    const std::vector<std::string> words = words_of(name);
    const bool hot = place_in(kFire, words).has_value(), none = place_in(kNoFog, words).has_value();
    // A level set is a surface whatever it is called.
    if (!level_set && !hot && !none) {
        for (std::size_t i = 0; i < kFog.size(); ++i)
            if (whole == kFog[i])
                return rank::kExact + static_cast<int>(i);
        if (const std::optional<int> place = place_in(kFog, words))
            return rank::kWithin + *place;
        return rank::kUnknown + (grid_class == "fog volume" ? 0 : 1);
    }
    if (level_set)
        return none || hot ? rank::kNone : rank::kLevelSet;
    return none ? rank::kNone + 1 : rank::kHot;
}

bool like_smoke(std::string_view name, std::string_view grid_class)
{
    return fog_rank(name, grid_class) < rank::kHot;
}

std::optional<std::size_t> find_name(const std::vector<GridName>& grids, std::string_view wanted)
{
    const auto find = [&](const auto& is_it) -> std::optional<std::size_t> {
        const auto it = std::find_if(grids.begin(), grids.end(), is_it);
        return it == grids.end() ? std::nullopt
                                 : std::optional(static_cast<std::size_t>(it - grids.begin()));
    };
    const std::string lower_wanted = lower_case(wanted);
    std::optional<std::size_t> found = find([&](const GridName& g) { return g.address == wanted; });
    if (!found)
        found = find([&](const GridName& g) { return g.name == wanted; });
    if (!found)
        found = find([&](const GridName& g) { return lower_case(g.address) == lower_wanted; });
    if (!found)
        found = find([&](const GridName& g) { return lower_case(g.name) == lower_wanted; });
    return found;
}

std::optional<std::array<std::size_t, 3>> find_channels(const std::vector<GridName>& grids,
                                                        std::string_view wanted)
{
    if (wanted.empty())
        return std::nullopt;
    for (const std::string_view between : {".", "_", ""}) {
        for (const std::string_view letters : {"xyz", "rgb"}) {
            std::array<std::size_t, 3> channels{};
            bool all = true;
            for (std::size_t c = 0; c < 3 && all; ++c) {
                std::string name(wanted);
                name += between;
                name += letters[c];
                const std::optional<std::size_t> found = find_name(grids, name);
                all = found.has_value();
                channels[c] = found.value_or(0);
            }
            if (all)
                return channels;
        }
    }
    return std::nullopt;
}

const std::vector<std::string_view>& temperature_names()
{
    static const std::vector<std::string_view> names{"temperature", "temp", "kelvin", "heat"};
    return names;
}

const std::vector<std::string_view>& color_names()
{
    static const std::vector<std::string_view> names{"cd",  "color",  "colour",
                                                     "rgb", "albedo", "diffuse"};
    return names;
}

}  // namespace fumarole::asset
