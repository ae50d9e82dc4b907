#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include <fumarole/errors.h>

// A scene's members as JSON text, numbers such that they read back to the same bits. Private to
// src/asset, as the JSON library is.

namespace fumarole::asset {

/// Where a file lies that is named in one of `folder`.
inline std::filesystem::path resolved(const std::filesystem::path& folder, const std::string& name)
{
    return (folder / std::filesystem::path(name)).lexically_normal();
}

inline constexpr std::size_t kLineWidth = 100;

template <typename T> std::string number_text(T value)
{
    if (value == 0 && std::signbit(value))
        return "-0.0";  // "-0" reads as an integer, which has no sign
    std::string text = fmt::format("{}", value);
    // The shortest text of a float, read as a double and rounded, may miss it by one bit.
    if (static_cast<T>(std::strtod(text.c_str(), nullptr)) != value)
        text = fmt::format("{:.17g}", value);
    return text;
}

template <typename T> std::string triple_text(const T& value)
{
    return fmt::format("[{}, {}, {}]", number_text(value.x), number_text(value.y),
                       number_text(value.z));
}

/// The members of an object as text, laid out on one line if they fit.
class Members {
public:
    explicit Members(std::string place) : place_(std::move(place)) {}

    void raw(std::string_view key, std::string text)
    {
        members_.push_back(fmt::format("\"{}\": {}", key, std::move(text)));
    }

    void text(std::string_view key, const std::string& value)
    {
        try {
            raw(key, nlohmann::json(value).dump());
        } catch (const nlohmann::json::exception&) {
            fail(key, "is not UTF-8");
        }
    }

    template <typename T> void number(std::string_view key, T value)
    {
        if constexpr (std::is_floating_point_v<T>) {
            if (!std::isfinite(value))
                fail(key, "is not finite");
            raw(key, number_text(value));
        } else {
            raw(key, fmt::format("{}", value));
        }
    }

    template <typename T> void triple(std::string_view key, const T& value)
    {
        if (!std::isfinite(value.x) || !std::isfinite(value.y) || !std::isfinite(value.z))
            fail(key, "is not finite");
        raw(key, triple_text(value));
    }

    void two(std::string_view key, const glm::dvec2& value)
    {
        if (!std::isfinite(value.x) || !std::isfinite(value.y))
            fail(key, "is not finite");
        raw(key, fmt::format("[{}, {}]", number_text(value.x), number_text(value.y)));
    }

    void pair(std::string_view key, const std::array<glm::dvec3, 2>& values)
    {
        for (const glm::dvec3& value : values)
            if (!std::isfinite(value.x) || !std::isfinite(value.y) || !std::isfinite(value.z))
                fail(key, "is not finite");
        raw(key, fmt::format("[{}, {}]", triple_text(values[0]), triple_text(values[1])));
    }

    [[nodiscard]] std::string in_lines(std::size_t indent) const
    {
        std::string out = "{";
        std::size_t column = indent + 1;
        for (std::size_t i = 0; i < members_.size(); ++i) {
            if (i > 0) {
                const bool full = column + members_[i].size() + 3 > kLineWidth;
                out += full ? ",\n" + std::string(indent + 1, ' ') : ", ";
                column = full ? indent + 1 : column + 2;
            }
            out += members_[i];
            column += members_[i].size();
        }
        return out + "}";
    }

    [[nodiscard]] const std::vector<std::string>& list() const { return members_; }

private:
    [[noreturn]] void fail(std::string_view key, const char* problem) const
    {
        throw Error(fmt::format("the scene cannot be written: {}{}{} {}", place_,
                                place_.empty() ? "" : ".", key, problem));
    }

    std::string place_;
    std::vector<std::string> members_;
};

inline constexpr std::size_t kItemIndent = 4;

inline std::string list_text(const std::vector<std::string>& items)
{
    if (items.empty())
        return "[]";
    return fmt::format("[\n    {}\n  ]", fmt::join(items, ",\n    "));
}

/// Names below the folder, or below the one it stands in, stay valid when both are moved together.
inline std::string relative_name(const std::string& file, const std::filesystem::path& folder)
{
    if (file.empty())
        return file;
    const std::filesystem::path absolute = std::filesystem::absolute(file).lexically_normal();
    const std::filesystem::path relative =
        absolute.lexically_relative((std::filesystem::current_path() / folder).lexically_normal());
    const auto climbs = std::count(relative.begin(), relative.end(), std::filesystem::path(".."));
    return relative.empty() || climbs > 1 ? absolute.string() : relative.string();
}

}  // namespace fumarole::asset
