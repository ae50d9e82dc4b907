// Pictures in memory to PNG: the display's curve, straight alpha, and the file itself.

#include <fumarole/write/image_writer.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <new>
#include <optional>
#include <span>
#include <string_view>

#include <fmt/format.h>
#include <zlib.h>

#include "write/picture_checks.h"
#include "write/whole_file.h"
#include <fumarole/errors.h>

namespace fumarole::write {
namespace {

namespace fs = std::filesystem;

// The nearest of 0..255 to a display-encoded 0..1.
std::uint8_t to_byte(float encoded)
{
    return static_cast<std::uint8_t>(std::lround(std::clamp(encoded, 0.0f, 1.0f) * 255.0f));
}

struct EncodedPixel {
    glm::vec3 rgb;  ///< display-encoded, not multiplied by alpha
    float alpha;
};

// PNG's alpha is straight, ours premultiplied; and light is divided before the display's curve, not
// after. Light that covers nothing has no straight form: it keeps its colour, for viewers that drop
// alpha.
EncodedPixel straight(glm::vec3 radiance, float alpha, const Display& display)
{
    return {display_transform(alpha > 0 ? radiance / alpha : radiance, display), alpha};
}

// Over black the pixel is to look as what covers would, with what glows added as a screen shows it.
// Alpha is then as large as it must be for that: the brightest channel.
EncodedPixel with_glow(glm::vec3 radiance, glm::vec3 cover, float alpha, const Display& display)
{
    cover = glm::min(cover, radiance);
    const EncodedPixel covering = straight(cover, alpha, display);
    const glm::vec3 glow = display_transform(radiance, display) - display_transform(cover, display);
    const glm::vec3 over_black = alpha * covering.rgb + glm::max(glow, glm::vec3(0));
    const float brightest = std::max({over_black.r, over_black.g, over_black.b});
    const float raised = std::min(1.0f, std::max(alpha, brightest));
    return {raised > 0 ? over_black / raised : over_black, raised};
}

void append_number(std::vector<unsigned char>& to, std::uint32_t number)
{
    for (const int shift : {24, 16, 8, 0})
        to.push_back(static_cast<unsigned char>(number >> shift & 0xff));
}

void append_chunk(std::vector<unsigned char>& to, std::string_view type,
                  std::span<const unsigned char> data)
{
    append_number(to, static_cast<std::uint32_t>(data.size()));
    const std::size_t begin = to.size();
    to.insert(to.end(), type.begin(), type.end());
    to.insert(to.end(), data.begin(), data.end());
    append_number(to, static_cast<std::uint32_t>(::crc32_z(0, &to[begin], to.size() - begin)));
}

/// Of the pixels to the left, above, and above to the left, the nearest to what a plane through
/// them would have here (Paeth, in the PNG specification).
int paeth(int left, int above, int corner)
{
    const int to_left = std::abs(above - corner), to_above = std::abs(left - corner),
              to_corner = std::abs(left + above - 2 * corner);
    if (to_left <= to_above && to_left <= to_corner)
        return left;
    return to_above <= to_corner ? above : corner;
}

/// A row as differences from what a filter expects. @returns the sum of their sizes
template <int filter>
unsigned filter_row(std::span<const std::uint8_t> row, std::span<const std::uint8_t> above,
                    std::size_t channels, std::span<unsigned char> out)
{
    unsigned sum = 0;
    for (std::size_t i = 0; i < row.size(); ++i) {
        const int left = i < channels ? 0 : row[i - channels];
        const int up = above[i];
        const int corner = i < channels ? 0 : above[i - channels];
        const int expected = filter == 0   ? 0
                             : filter == 1 ? left
                             : filter == 2 ? up
                             : filter == 3 ? (left + up) / 2
                                           : paeth(left, up, corner);
        out[i] = static_cast<unsigned char>(row[i] - expected);
        sum += static_cast<unsigned>(std::abs(static_cast<signed char>(out[i])));
    }
    return sum;
}

/// Each row by the filter that leaves the least, as the PNG specification advises.
std::vector<unsigned char> filtered(std::span<const std::uint8_t> pixels, std::size_t row_bytes,
                                    std::size_t channels)
{
    constexpr std::array kFilters{filter_row<0>, filter_row<1>, filter_row<2>, filter_row<3>,
                                  filter_row<4>};
    const std::vector<unsigned char> none(row_bytes);  // above the first
    std::vector<unsigned char> rows, row(row_bytes), best(row_bytes);
    rows.reserve(pixels.size() + pixels.size() / row_bytes);
    for (std::size_t at = 0; at < pixels.size(); at += row_bytes) {
        const std::span<const std::uint8_t> above =
            at > 0 ? pixels.subspan(at - row_bytes, row_bytes) : std::span(none);
        unsigned least = std::numeric_limits<unsigned>::max();
        std::size_t chosen = 0;
        for (std::size_t filter = 0; filter < kFilters.size(); ++filter) {
            const unsigned sum =
                kFilters[filter](pixels.subspan(at, row_bytes), above, channels, row);
            if (sum < least) {
                least = sum;
                chosen = filter;
                best.swap(row);
            }
        }
        rows.push_back(static_cast<unsigned char>(chosen));
        rows.insert(rows.end(), best.begin(), best.end());
    }
    return rows;
}

std::vector<unsigned char> deflated(std::vector<unsigned char> bytes)
{
    z_stream stream{};
    constexpr int kWindowBits = 15, kMemory = 8;  // zlib's own
    if (::deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, kWindowBits, kMemory,
                       Z_FILTERED) != Z_OK)
        throw std::bad_alloc();
    std::vector<unsigned char> out(::deflateBound(&stream, bytes.size()));
    stream.next_in = bytes.data();
    stream.next_out = out.data();
    constexpr std::size_t kMostAtOnce = std::size_t(1) << 30;  // its counts have 32 bits
    int ended = Z_OK;
    while (ended == Z_OK) {
        if (stream.avail_in == 0)
            stream.avail_in =
                static_cast<uInt>(std::min(kMostAtOnce, bytes.size() - stream.total_in));
        if (stream.avail_out == 0)
            stream.avail_out =
                static_cast<uInt>(std::min(kMostAtOnce, out.size() - stream.total_out));
        ended = ::deflate(&stream, stream.total_in + stream.avail_in == bytes.size() ? Z_FINISH
                                                                                     : Z_NO_FLUSH);
    }
    out.resize(stream.total_out);
    ::deflateEnd(&stream);
    assert(ended == Z_STREAM_END);
    static_cast<void>(ended);
    return out;
}

/// 3 channels are RGB, 4 have a straight alpha. By our own hand: OpenImageIO, which reads and
/// writes all else, takes a quarter of a second to be opened.
std::vector<unsigned char> encoded_png(int width, int height, std::size_t channels,
                                       std::span<const std::uint8_t> pixels)
{
    std::vector<unsigned char> png{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    std::vector<unsigned char> header;
    append_number(header, static_cast<std::uint32_t>(width));
    append_number(header, static_cast<std::uint32_t>(height));
    const unsigned char kind = channels == 4 ? 6 : 2;
    header.insert(header.end(), {8, kind, 0, 0, 0});
    append_chunk(png, "IHDR", header);
    constexpr std::array<unsigned char, 1> kPerceptual{0};
    append_chunk(png, "sRGB", kPerceptual);
    constexpr std::string_view kSoftware("Software\0Fumarole", 17);
    append_chunk(png, "tEXt", std::vector<unsigned char>(kSoftware.begin(), kSoftware.end()));
    const std::vector<unsigned char> data =
        deflated(filtered(pixels, static_cast<std::size_t>(width) * channels, channels));
    constexpr std::size_t kMostOfAChunk = std::size_t(1) << 30;
    for (std::size_t at = 0; at < data.size(); at += kMostOfAChunk)
        append_chunk(png, "IDAT",
                     std::span(data).subspan(at, std::min(kMostOfAChunk, data.size() - at)));
    append_chunk(png, "IEND", {});
    return png;
}

}  // namespace

void write_png(const Image& image, const Display& display, const fs::path& file)
{
    check_shape(image, file);
    std::vector<int> used;
    for (const char* name : {"R", "G", "B"}) {
        const std::optional<int> channel = find_channel(image.channels, name);
        if (!channel) {
            throw Error(fmt::format("{}: the picture has no channel '{}' (has: {}); a PNG needs "
                                    "R, G and B",
                                    file.string(), name, channel_names(image.channels)));
        }
        used.push_back(*channel);
    }
    const std::optional<int> alpha_channel = find_channel(image.channels, "A");
    if (alpha_channel) {
        used.push_back(*alpha_channel);
    }
    const std::optional<int> cover =
        alpha_channel ? find_channel(image.channels, "cover.R") : std::nullopt;
    const std::size_t stored = used.size();
    if (cover) {
        for (int c = 0; c < 3; ++c)
            used.push_back(*cover + c);
    }
    check_finite(image, used, file);

    std::vector<std::uint8_t> pixels;
    pixels.reserve(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) *
                   stored);
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            const auto rgb = [&](std::size_t first) {
                return glm::vec3(image.at(x, y, used[first]), image.at(x, y, used[first + 1]),
                                 image.at(x, y, used[first + 2]));
            };
            EncodedPixel pixel{display_transform(rgb(0), display), 1};
            if (alpha_channel) {
                const float alpha = std::clamp(image.at(x, y, *alpha_channel), 0.0f, 1.0f);
                pixel = cover ? with_glow(rgb(0), rgb(stored), alpha, display)
                              : straight(rgb(0), alpha, display);
            }
            for (int c = 0; c < 3; ++c)
                pixels.push_back(to_byte(pixel.rgb[c]));
            if (alpha_channel)
                pixels.push_back(to_byte(pixel.alpha));
        }
    }

    write_whole(file, encoded_png(image.width, image.height, stored, pixels));
}

}  // namespace fumarole::write
