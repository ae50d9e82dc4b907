#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <glm/glm.hpp>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

// Strict reading of JSON: every complaint names the file, the place in it, and what was expected.
// Private to src/asset, as the JSON library is.

namespace fumarole::asset {

using Json = nlohmann::json;

/// Text to tree. Keys that occur twice and nesting without end are refused here, since the tree
/// would hide the one and overflow the stack of whoever walks the other.
/// @throws Error `file: line 3, column 7: not valid JSON: ...`
Json parse_json(std::string_view text, const std::string& file);

/// Where in a file a value stands: `media[1].sigma_s`.
struct JsonPlace {
    std::string file;
    std::string path;

    [[nodiscard]] JsonPlace key(std::string_view name) const;
    [[nodiscard]] JsonPlace index(std::size_t i) const;
    [[noreturn]] void fail(const std::string& problem) const;
};

/// Keys of the tools that write the same scenes for other renderers: allowed anywhere, never read.
std::span<const std::string_view> foreign_keys();

/// What a number may be; never infinite or NaN.
struct NumberRange {
    double min = -std::numeric_limits<double>::infinity();
    double max = std::numeric_limits<double>::infinity();
    bool min_open = false;
    bool max_open = false;
    const char* unit = "";

    [[nodiscard]] bool contains(double value) const;
    [[nodiscard]] std::string text() const;  ///< `in (0, 180) (degrees)`
};

/// An object whose keys are read one by one into variables that hold their defaults. finish() then
/// knows which keys nobody asked for. A key that is missing is remembered until finish() too: if a
/// key is misspelt, that is the better thing to say.
class JsonObject {
public:
    JsonObject(const Json& value, JsonPlace place);

    [[nodiscard]] const JsonPlace& place() const { return place_; }
    [[nodiscard]] bool has(std::string_view key) const;

    /// `read` keeps the default where the key is missing, `need` complains.
    template <typename T> bool read(std::string_view key, const NumberRange& range, T& target);
    template <typename T> void need(std::string_view key, const NumberRange& range, T& target);
    bool read(std::string_view key, std::string& target);
    bool read(std::string_view key, bool& target);
    /// Two edges of a parallelogram, in the file a list of two vectors.
    bool read(std::string_view key, const NumberRange& range, std::array<glm::dvec3, 2>& edges);
    void need(std::string_view key, const NumberRange& range, std::array<glm::dvec3, 2>& edges);

    /// The position of a name among those allowed; `fallback` if the key is missing.
    std::size_t choice(std::string_view key, const std::vector<std::string_view>& names,
                       std::size_t fallback);
    std::size_t need_choice(std::string_view key, const std::vector<std::string_view>& names);

    /// A name of a file, not empty.
    void need_file(std::string_view key, std::string& target);

    /// A list of objects; none where the key is missing.
    void read_list(std::string_view key, const std::function<void(JsonObject)>& read_item);

    /// The value of a key, or nullptr.
    const Json* find(std::string_view key);
    void ignore(std::string_view key);

    /// @throws Error if a key was never asked for, or one that was needed is missing.
    void finish() const;

private:
    void miss(std::string_view key, const std::string& expected);

    const Json& value_;
    JsonPlace place_;
    std::vector<std::string> asked_;
    std::vector<std::string> ignored_;
    std::string missing_;
};

/// One value, checked. T: float, double, int, std::uint32_t; or a glm vector of these, which stands
/// in the file as a list. Integers may be written as 5.0.
template <typename T> T json_value(const Json& value, const JsonPlace& place, const NumberRange&);

}  // namespace fumarole::asset
