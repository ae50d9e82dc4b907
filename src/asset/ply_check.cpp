#include "asset/ply_check.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fmt/format.h>
#include <string_view>
#include <vector>

#include "asset/printable.h"
#include <fumarole/errors.h>

namespace fumarole::asset {

namespace {

static_assert(std::endian::native == std::endian::little, "numbers are read as they lie");

enum class Encoding { ascii, little_endian, big_endian };
enum class Number { none, i8, u8, i16, u16, i32, u32, f32, f64 };

struct Property {
    std::string name;
    Number count = Number::none;  // none: no list
    Number item = Number::none;
};

struct Element {
    std::string name;
    std::uint64_t rows = 0;
    std::vector<Property> properties;
};

Number number_type(std::string_view name)
{
    constexpr std::array<std::pair<std::string_view, Number>, 16> kNames = {
        {{"char", Number::i8},
         {"int8", Number::i8},
         {"uchar", Number::u8},
         {"uint8", Number::u8},
         {"short", Number::i16},
         {"int16", Number::i16},
         {"ushort", Number::u16},
         {"uint16", Number::u16},
         {"int", Number::i32},
         {"int32", Number::i32},
         {"uint", Number::u32},
         {"uint32", Number::u32},
         {"float", Number::f32},
         {"float32", Number::f32},
         {"double", Number::f64},
         {"float64", Number::f64}}};
    for (const auto& [known, type] : kNames) {
        if (known == name)
            return type;
    }
    throw Error(fmt::format("its PLY header has a property of unknown type '{}'", printable(name)));
}

bool is_space(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

class Reader {
public:
    explicit Reader(std::string_view bytes) : bytes_(bytes) {}

    std::vector<std::string_view> header_line()
    {
        const std::size_t end = bytes_.find_first_of("\r\n", at_);
        if (end == std::string_view::npos)
            throw Error("truncated: its PLY header has no end");
        std::string_view line = bytes_.substr(at_, end - at_);
        at_ = end + (bytes_.substr(end, 2) == "\r\n" ? 2 : 1);
        std::vector<std::string_view> words;
        while (true) {
            while (!line.empty() && is_space(line.front()))
                line.remove_prefix(1);
            if (line.empty())
                return words;
            const std::size_t length = std::min(line.find_first_of(" \t"), line.size());
            words.push_back(line.substr(0, length));
            line.remove_prefix(length);
        }
    }

    double number(Number type)
    {
        if (encoding == Encoding::ascii)
            return word();
        switch (type) {
        case Number::i8:
            return raw<std::int8_t>();
        case Number::u8:
            return raw<std::uint8_t>();
        case Number::i16:
            return raw<std::int16_t>();
        case Number::u16:
            return raw<std::uint16_t>();
        case Number::i32:
            return raw<std::int32_t>();
        case Number::u32:
            return raw<std::uint32_t>();
        case Number::f32:
            return raw<float>();
        default:
            return raw<double>();
        }
    }

    // Whole and not negative, as counts and indices are.
    std::uint64_t index(Number type)
    {
        const double value = number(type);
        if (!(value >= 0) || value > 4294967295.0 || value != std::floor(value))
            throw Error("damaged: a list of its PLY has a negative or fractional count or index");
        return static_cast<std::uint64_t>(value);
    }

    Encoding encoding = Encoding::ascii;

private:
    double word()
    {
        while (at_ < bytes_.size() && is_space(bytes_[at_]))
            ++at_;
        std::size_t end = at_;
        while (end < bytes_.size() && !is_space(bytes_[end]))
            ++end;
        if (end == at_)
            throw Error("truncated: ends before all that its PLY header promises");
        double value = 0;
        std::size_t start = at_;
        if (bytes_[start] == '+')
            ++start;
        const auto [stop, problem] = std::from_chars(&bytes_[start], bytes_.data() + end, value);
        if (stop != bytes_.data() + end || problem == std::errc::invalid_argument)
            throw Error(fmt::format("damaged: expected a number, got '{}'",
                                    printable(bytes_.substr(at_, end - at_))));
        at_ = end;
        return value;
    }

    template <typename T> T raw()
    {
        if (bytes_.size() - at_ < sizeof(T))
            throw Error("truncated: ends before all that its PLY header promises");
        std::array<char, sizeof(T)> value{};
        std::memcpy(value.data(), bytes_.data() + at_, sizeof(T));
        if (encoding == Encoding::big_endian)
            std::reverse(value.begin(), value.end());
        at_ += sizeof(T);
        return std::bit_cast<T>(value);
    }

    std::string_view bytes_;
    std::size_t at_ = 0;
};

std::vector<Element> read_header(Reader& reader)
{
    std::vector<Element> elements;
    bool has_format = false;
    while (true) {
        const std::vector<std::string_view> words = reader.header_line();
        if (words.empty() || words[0] == "comment" || words[0] == "obj_info")
            continue;
        if (words[0] == "end_header")
            break;
        if (words[0] == "format" && words.size() >= 2) {
            has_format = true;
            if (words[1] == "ascii")
                reader.encoding = Encoding::ascii;
            else if (words[1] == "binary_little_endian")
                reader.encoding = Encoding::little_endian;
            else if (words[1] == "binary_big_endian")
                reader.encoding = Encoding::big_endian;
            else
                throw Error(fmt::format("its PLY format '{}' is unknown", printable(words[1])));
        } else if (words[0] == "element" && words.size() == 3) {
            Element element{std::string(words[1]), 0, {}};
            const char* end = words[2].data() + words[2].size();
            const auto [stop, problem] = std::from_chars(words[2].data(), end, element.rows);
            if (stop != end || problem != std::errc())
                throw Error(fmt::format("its PLY header counts '{}' rows", printable(words[2])));
            elements.push_back(std::move(element));
        } else if (words[0] == "property" && words.size() == 3 && !elements.empty()) {
            elements.back().properties.push_back(
                {std::string(words[2]), Number::none, number_type(words[1])});
        } else if (words[0] == "property" && words.size() == 5 && words[1] == "list" &&
                   !elements.empty()) {
            elements.back().properties.push_back(
                {std::string(words[4]), number_type(words[2]), number_type(words[3])});
        } else {
            throw Error(fmt::format("its PLY header has a line '{}' that makes no sense",
                                    printable(fmt::format("{}", fmt::join(words, " ")))));
        }
    }
    if (!has_format)
        throw Error("its PLY header has no format");
    return elements;
}

void read_rows(Reader& reader, const Element& element, PlyPolygons& out)
{
    constexpr std::array<std::string_view, 6> kVertex = {"x", "y", "z", "nx", "ny", "nz"};
    const bool is_vertex = element.name == "vertex";
    // What each property means: its place in a vertex, or none.
    std::vector<std::size_t> slots;
    std::size_t coordinates = 0;
    for (const Property& property : element.properties) {
        const auto* found = std::find(kVertex.begin(), kVertex.end(), property.name);
        const bool used = is_vertex && property.count == Number::none && found != kVertex.end();
        slots.push_back(used ? static_cast<std::size_t>(found - kVertex.begin()) : kVertex.size());
        coordinates += used ? 1 : 0;
    }
    if (is_vertex && coordinates < 3)
        throw Error("its PLY header has no x, y and z of a vertex");
    if (is_vertex)
        out.has_normals = coordinates == kVertex.size();

    for (std::uint64_t row = 0; row < element.rows && !element.properties.empty(); ++row) {
        std::array<float, 6> vertex{};
        for (std::size_t i = 0; i < element.properties.size(); ++i) {
            const Property& property = element.properties[i];
            if (property.count == Number::none) {
                const double value = reader.number(property.item);
                if (slots[i] < kVertex.size())
                    vertex[slots[i]] = static_cast<float>(value);
                continue;
            }
            const bool is_face = element.name == "face" && (property.name == "vertex_indices" ||
                                                            property.name == "vertex_index");
            const std::uint64_t length = reader.index(property.count);
            std::vector<std::uint32_t> corners;
            for (std::uint64_t k = 0; k < length; ++k) {
                if (is_face)
                    corners.push_back(static_cast<std::uint32_t>(reader.index(property.item)));
                else
                    reader.number(property.item);
            }
            if (corners.size() >= 3)
                out.faces.push_back(std::move(corners));
        }
        if (is_vertex) {
            if (!std::isfinite(vertex[0]) || !std::isfinite(vertex[1]) || !std::isfinite(vertex[2]))
                throw Error(fmt::format("vertex {} is not finite", row));
            out.vertices.push_back(vertex);
        }
    }
}

}  // namespace

std::optional<PlyPolygons> read_ply(std::string_view bytes)
{
    Reader reader(bytes);
    if (!bytes.starts_with("ply\n") && !bytes.starts_with("ply\r"))
        return std::nullopt;
    reader.header_line();
    PlyPolygons polygons;
    for (const Element& element : read_header(reader))
        read_rows(reader, element, polygons);
    for (const auto& face : polygons.faces) {
        for (const std::uint32_t corner : face) {
            if (corner >= polygons.vertices.size())
                throw Error(fmt::format("damaged: a face names vertex {} of {}", corner,
                                        polygons.vertices.size()));
        }
    }
    if (polygons.faces.empty())
        throw Error("has no triangle");
    return polygons;
}

}  // namespace fumarole::asset
