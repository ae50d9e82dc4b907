#include "asset/json_reader.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <type_traits>
#include <utility>

#include "asset/printable.h"
#include <fumarole/errors.h>

namespace fumarole::asset {

namespace {

// The format itself nests four deep; the rest is room for what other tools keep beside it.
constexpr std::size_t kMaxDepth = 32;

constexpr std::string_view kForeignKeys[] = {"$schema",  // by which editors find ours
                                             "title",
                                             "note",
                                             "id",
                                             "formula",
                                             "axes",
                                             "phase",
                                             "surface_radiance",
                                             "interpolation",
                                             "color",
                                             "blender_strength",
                                             "blender_power_W",
                                             "angle_deg"};

std::string line_and_column(std::string_view text, std::size_t offset)
{
    offset = std::min(offset, text.size());
    const std::string_view before = text.substr(0, offset);
    const auto line = 1 + std::count(before.begin(), before.end(), '\n');
    const std::size_t newline = before.rfind('\n');
    const std::size_t column = newline == std::string_view::npos ? offset : offset - newline - 1;
    return fmt::format("line {}, column {}", line, std::max<std::size_t>(column, 1));
}

/// What a person most likely meant where the text is no JSON, and what to do about it; or "".
std::string remedy(std::string_view text, std::size_t position)
{
    if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff") ||
        text.substr(0, 2).find('\0') != std::string_view::npos)
        return "; is it UTF-16? Save it as UTF-8";
    // The parser stops behind the character that it can't take.
    const std::string_view read = text.substr(0, std::min(position, text.size()));
    const std::size_t word = read.find_last_of(" \t\r\n,:[{") + 1;  // 0 where there is none
    const std::string_view last = text.substr(word);
    const std::size_t before =
        read.empty() ? read.npos : read.find_last_not_of(" \t\r\n", read.size() - 2);
    if (last.starts_with('/') || last.starts_with('#') || read.ends_with('/'))
        return "; JSON has no comments: take it out, or make it a \"note\"";
    if (last.starts_with("N") || last.starts_with("I") || last.starts_with("-I") ||
        last.starts_with("i"))
        return "; JSON has no NaN and no infinity: give a number";
    if (last.starts_with('\'') || read.ends_with('\''))
        return "; text stands in double quotes";
    if ((read.ends_with('}') || read.ends_with(']')) && before != read.npos && read[before] == ',')
        return "; take out the comma before it";
    return "";
}

// Builds the tree as nlohmann's own builder does, but sees duplicates, depth and positions.
class TreeBuilder : public nlohmann::json_sax<Json> {
public:
    TreeBuilder(std::string_view text, JsonPlace place) : text_(text), place_(std::move(place)) {}

    Json take() { return std::move(root_); }

    bool null() override { return add(nullptr); }
    bool boolean(bool value) override { return add(value); }
    bool number_integer(number_integer_t value) override { return add(value); }
    bool number_unsigned(number_unsigned_t value) override { return add(value); }
    bool number_float(number_float_t value, const string_t&) override { return add(value); }
    bool string(string_t& value) override { return add(std::move(value)); }
    bool binary(binary_t&) override { return true; }
    bool start_object(std::size_t) override { return open(Json::object()); }
    bool start_array(std::size_t) override { return open(Json::array()); }
    bool end_object() override { return close(); }
    bool end_array() override { return close(); }

    bool key(string_t& name) override
    {
        Json& object = *open_.back().value;
        if (object.contains(name))
            where().fail(fmt::format("key '{}' occurs twice", printable(name)));
        open_.back().slot = &object[name];
        open_.back().key = name;
        return true;
    }

    bool parse_error(std::size_t position, const std::string&,
                     const nlohmann::detail::exception& error) override
    {
        // "[json.exception.parse_error.101] parse error at line 1, column 5: what is wrong"
        std::string message = error.what();
        // What the parser read last stands in the message, and need not be valid UTF-8.
        std::replace_if(
            message.begin(), message.end(),
            [](char c) { return static_cast<unsigned char>(c) >= 0x80; }, '?');
        std::string_view what = message;
        for (const std::string_view prefix : {"] ", ": "}) {
            const bool titled = prefix == "] " || what.starts_with("parse error");
            if (const auto at = what.find(prefix); titled && at != std::string_view::npos)
                what.remove_prefix(at + prefix.size());
        }
        JsonPlace{place_.file, line_and_column(text_, position)}.fail(
            "not valid JSON: " + printable(what, 240) + remedy(text_, position));
    }

private:
    struct Open {
        Json* value = nullptr;
        Json* slot = nullptr;  // of an object: where the value of the last key goes
        std::string key;
    };

    JsonPlace where() const
    {
        JsonPlace place = place_;
        for (std::size_t i = 0; i + 1 < open_.size(); ++i) {
            const Open& level = open_[i];
            place = level.value->is_array() ? place.index(level.value->size() - 1)
                                            : place.key(level.key);
        }
        return place;
    }

    template <typename T> Json* place_value(T&& value)
    {
        if (open_.empty()) {
            root_ = std::forward<T>(value);
            return &root_;
        }
        Open& parent = open_.back();
        if (parent.value->is_array()) {
            parent.value->push_back(std::forward<T>(value));
            return &parent.value->back();
        }
        *parent.slot = std::forward<T>(value);
        return parent.slot;
    }

    template <typename T> bool add(T&& value)
    {
        place_value(std::forward<T>(value));
        return true;
    }

    bool open(Json&& value)
    {
        if (open_.size() == kMaxDepth)
            place_.fail(fmt::format("nested deeper than {} levels", kMaxDepth));
        open_.push_back({place_value(std::move(value)), nullptr, {}});
        return true;
    }

    bool close()
    {
        open_.pop_back();
        return true;
    }

    std::string_view text_;
    JsonPlace place_;
    Json root_;
    std::vector<Open> open_;
};

std::string shown(const Json& value)
{
    switch (value.type()) {
    case Json::value_t::object:
        return "an object";
    case Json::value_t::array:
        return fmt::format("a list of {}", value.size());
    case Json::value_t::string:
        return fmt::format("the text '{}'", printable(value.get_ref<const std::string&>()));
    default:
        return value.dump();
    }
}

template <typename T> constexpr int kComponents = 1;
template <int N, typename T> constexpr int kComponents<glm::vec<N, T>> = N;

template <typename T> std::string expected_value(const NumberRange& range)
{
    constexpr const char* kCounts[] = {"", "", "two numbers", "three numbers", "four numbers"};
    constexpr int n = kComponents<T>;
    const std::string text = range.text();
    if constexpr (n > 1)
        return fmt::format("a list of {}{}{}", kCounts[n], text.empty() ? "" : ", each ", text);
    else
        return fmt::format("a {}number {}", std::is_integral_v<T> ? "whole " : "", text);
}

template <typename T>
T checked_number(const Json& value, const JsonPlace& place, const NumberRange& range)
{
    const auto fail = [&] {
        std::string expected = expected_value<T>(range);
        while (expected.ends_with(' '))
            expected.pop_back();
        place.fail(fmt::format("expected {}, got {}", expected, shown(value)));
    };
    if (!value.is_number())
        fail();
    const auto number = value.get<double>();
    if (!std::isfinite(number) || !range.contains(number))
        fail();
    if constexpr (std::is_integral_v<T>) {
        if (number != std::floor(number) ||
            number < static_cast<double>(std::numeric_limits<T>::min()) ||
            number > static_cast<double>(std::numeric_limits<T>::max()))
            fail();
    } else if constexpr (std::is_same_v<T, float>) {
        // Rounding to float may reach an open end, or infinity.
        if (std::abs(number) > static_cast<double>(std::numeric_limits<float>::max()) ||
            !range.contains(static_cast<double>(static_cast<float>(number))))
            fail();
    }
    return static_cast<T>(number);
}

}  // namespace

std::span<const std::string_view> foreign_keys()
{
    return kForeignKeys;
}

JsonPlace JsonPlace::key(std::string_view name) const
{
    return {file, path.empty() ? printable(name) : path + "." + printable(name)};
}

JsonPlace JsonPlace::index(std::size_t i) const
{
    return {file, fmt::format("{}[{}]", path, i)};
}

void JsonPlace::fail(const std::string& problem) const
{
    throw Error(path.empty() ? fmt::format("{}: {}", file, problem)
                             : fmt::format("{}: {}: {}", file, path, problem));
}

Json parse_json(std::string_view text, const std::string& file)
{
    TreeBuilder builder(text, {file, ""});
    Json::sax_parse(text.begin(), text.end(), &builder);
    return builder.take();
}

bool NumberRange::contains(double value) const
{
    return (min_open ? value > min : value >= min) && (max_open ? value < max : value <= max);
}

std::string NumberRange::text() const
{
    std::string out;
    if (std::isfinite(min) && std::isfinite(max))
        out = fmt::format("in {}{}, {}{}", min_open ? '(' : '[', min, max, max_open ? ')' : ']');
    if (unit[0] != '\0')
        out += fmt::format("{}({})", out.empty() ? "" : " ", unit);
    return out;
}

JsonObject::JsonObject(const Json& value, JsonPlace place) : value_(value), place_(std::move(place))
{
    if (!value.is_object())
        place_.fail(fmt::format("expected an object {{...}}, got {}", shown(value)));
}

bool JsonObject::has(std::string_view key) const
{
    return value_.find(key) != value_.end();
}

const Json* JsonObject::find(std::string_view key)
{
    if (std::find(asked_.begin(), asked_.end(), key) == asked_.end())
        asked_.emplace_back(key);  // once, as an error lists them
    const auto found = value_.find(key);
    return found == value_.end() ? nullptr : &*found;
}

void JsonObject::ignore(std::string_view key)
{
    ignored_.emplace_back(key);
}

void JsonObject::miss(std::string_view key, const std::string& expected)
{
    if (missing_.empty())
        missing_ = fmt::format("missing key '{}' (expected {})", key, expected);
}

constexpr const char* kTwoEdges = "two edges [[x, y, z], [x, y, z]]";

template <typename T>
bool JsonObject::read(std::string_view key, const NumberRange& range, T& target)
{
    const Json* value = find(key);
    if (value != nullptr)
        target = json_value<T>(*value, place_.key(key), range);
    return value != nullptr;
}

template <typename T>
void JsonObject::need(std::string_view key, const NumberRange& range, T& target)
{
    if (!read(key, range, target))
        miss(key, expected_value<T>(range));
}

bool JsonObject::read(std::string_view key, std::string& target)
{
    const Json* value = find(key);
    if (value == nullptr)
        return false;
    if (!value->is_string())
        place_.key(key).fail(fmt::format("expected a text, got {}", shown(*value)));
    target = value->get<std::string>();
    return true;
}

bool JsonObject::read(std::string_view key, bool& target)
{
    const Json* value = find(key);
    if (value == nullptr)
        return false;
    if (!value->is_boolean())
        place_.key(key).fail(fmt::format("expected true or false, got {}", shown(*value)));
    target = value->get<bool>();
    return true;
}

bool JsonObject::read(std::string_view key, const NumberRange& range,
                      std::array<glm::dvec3, 2>& edges)
{
    const Json* value = find(key);
    if (value == nullptr)
        return false;
    const JsonPlace place = place_.key(key);
    if (!value->is_array() || value->size() != edges.size())
        place.fail(fmt::format("expected {}, got {}", kTwoEdges, shown(*value)));
    for (std::size_t i = 0; i < edges.size(); ++i)
        edges.at(i) = json_value<glm::dvec3>((*value)[i], place.index(i), range);
    constexpr double kMinSine = 1e-6;
    const double lengths = glm::length(edges[0]) * glm::length(edges[1]);
    if (!(glm::length(glm::cross(edges[0], edges[1])) > kMinSine * lengths))
        place.fail("expected two edges that span an area, got one along the other");
    return true;
}

void JsonObject::need(std::string_view key, const NumberRange& range,
                      std::array<glm::dvec3, 2>& edges)
{
    if (!read(key, range, edges))
        miss(key, kTwoEdges);
}

std::size_t JsonObject::choice(std::string_view key, const std::vector<std::string_view>& names,
                               std::size_t fallback)
{
    const Json* value = find(key);
    if (value == nullptr)
        return fallback;
    if (value->is_string()) {
        const auto found =
            std::find(names.begin(), names.end(), value->get_ref<const std::string&>());
        if (found != names.end())
            return static_cast<std::size_t>(found - names.begin());
    }
    place_.key(key).fail(
        fmt::format("expected one of '{}', got {}", fmt::join(names, "', '"), shown(*value)));
}

std::size_t JsonObject::need_choice(std::string_view key,
                                    const std::vector<std::string_view>& names)
{
    if (!has(key))  // what else may stand here depends on it: no use in going on
        place_.fail(
            fmt::format("missing key '{}' (expected one of '{}')", key, fmt::join(names, "', '")));
    return choice(key, names, 0);
}

void JsonObject::need_file(std::string_view key, std::string& target)
{
    constexpr const char* kExpected = "the name of a file";
    if (!read(key, target))
        miss(key, kExpected);
    else if (target.empty() || target.find('\0') != std::string::npos)
        place_.key(key).fail(fmt::format("expected {}, got '{}'", kExpected, printable(target)));
}

void JsonObject::read_list(std::string_view key, const std::function<void(JsonObject)>& read_item)
{
    const Json* list = find(key);
    if (list == nullptr)
        return;
    const JsonPlace place = place_.key(key);
    if (!list->is_array())
        place.fail(fmt::format("expected a list [...], got {}", shown(*list)));
    for (std::size_t i = 0; i < list->size(); ++i)
        read_item(JsonObject((*list)[i], place.index(i)));
}

void JsonObject::finish() const
{
    for (const auto& item : value_.items()) {
        const auto is_key = [&](std::string_view name) { return name == item.key(); };
        if (std::none_of(asked_.begin(), asked_.end(), is_key) &&
            std::none_of(ignored_.begin(), ignored_.end(), is_key) &&
            std::none_of(std::begin(kForeignKeys), std::end(kForeignKeys), is_key))
            place_.fail(fmt::format("unknown key '{}' (known: {})", printable(item.key()),
                                    fmt::join(asked_, ", ")));
    }
    if (!missing_.empty())
        place_.fail(missing_);
}

template <typename T>
T json_value(const Json& value, const JsonPlace& place, const NumberRange& range)
{
    constexpr int n = kComponents<T>;
    if constexpr (n == 1) {
        return checked_number<T>(value, place, range);
    } else {
        if (!value.is_array() || value.size() != n)
            place.fail(fmt::format("expected {}, got {}", expected_value<T>(range), shown(value)));
        T out{};
        for (int i = 0; i < n; ++i) {
            const auto at = static_cast<std::size_t>(i);
            out[i] = checked_number<typename T::value_type>(value[at], place.index(at), range);
        }
        return out;
    }
}

// NOLINTBEGIN(bugprone-macro-parentheses): T is a type.
#define FUM_JSON_VALUE(T)                                                                          \
    template T json_value<T>(const Json&, const JsonPlace&, const NumberRange&);                   \
    template bool JsonObject::read<T>(std::string_view, const NumberRange&, T&);                   \
    template void JsonObject::need<T>(std::string_view, const NumberRange&, T&)
// NOLINTEND(bugprone-macro-parentheses)

FUM_JSON_VALUE(int);
FUM_JSON_VALUE(std::uint32_t);
FUM_JSON_VALUE(float);
FUM_JSON_VALUE(double);
FUM_JSON_VALUE(glm::uvec2);
FUM_JSON_VALUE(glm::dvec2);
FUM_JSON_VALUE(glm::vec3);
FUM_JSON_VALUE(glm::dvec3);

#undef FUM_JSON_VALUE

}  // namespace fumarole::asset
