// Pictures in memory to PNG: the display's curve, straight alpha, and the file itself.

#include <fumarole/write/image_writer.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <new>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <png.h>

#include "write/picture_checks.h"
#include "write/png_text.h"
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

/// What libpng writes with, and where to.
class PngStream {
public:
    PngStream()
        : png_{png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, throw_error, nullptr)},
          info_{png_ != nullptr ? png_create_info_struct(png_) : nullptr}
    {
        if (info_ == nullptr) {
            png_destroy_write_struct(&png_, nullptr);
            throw std::bad_alloc();
        }
        png_set_write_fn(png_, &bytes_, append, nullptr);
    }
    PngStream(const PngStream&) = delete;
    PngStream& operator=(const PngStream&) = delete;
    ~PngStream() { png_destroy_write_struct(&png_, &info_); }

    [[nodiscard]] png_structp png() { return png_; }
    [[nodiscard]] png_infop info() { return info_; }
    [[nodiscard]] std::vector<unsigned char> take() { return std::move(bytes_); }

private:
    // libpng asks that it is not returned from, and leaves nothing but what the destructor frees.
    [[noreturn]] static void throw_error(png_structp, png_const_charp why)
    {
        throw std::runtime_error(why);
    }
    static void append(png_structp png, png_bytep data, std::size_t size)
    {
        auto& bytes = *static_cast<std::vector<unsigned char>*>(png_get_io_ptr(png));
        bytes.insert(bytes.end(), data, data + size);
    }

    std::vector<unsigned char> bytes_;
    png_structp png_;
    png_infop info_;
};

/// 3 channels are RGB, 4 have a straight alpha. By libpng and not by OpenImageIO, which takes a
/// quarter of a second to be opened.
std::vector<unsigned char> encoded_png(int width, int height, std::size_t channels,
                                       std::span<const std::uint8_t> pixels,
                                       const std::vector<PngText>& texts)
{
    PngStream stream;
    png_structp png = stream.png();
    png_set_IHDR(png, stream.info(), static_cast<png_uint_32>(width),
                 static_cast<png_uint_32>(height), 8,
                 channels == 4 ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB(png, stream.info(), PNG_sRGB_INTENT_PERCEPTUAL);
    std::vector<PngText> all{{"Software", "Fumarole"}};
    all.insert(all.end(), texts.begin(), texts.end());
    std::string no_language;
    for (PngText& one : all) {
        const bool ascii = std::all_of(one.text.begin(), one.text.end(),
                                       [](char c) { return static_cast<unsigned char>(c) < 128; });
        png_text text{};
        // What is not ASCII is UTF-8 in a chunk that says so.
        text.compression = ascii ? PNG_TEXT_COMPRESSION_NONE : PNG_ITXT_COMPRESSION_NONE;
        text.key = one.key.data();
        text.text = one.text.data();
        text.lang = text.lang_key = no_language.data();
        png_set_text(png, stream.info(), &text, 1);
    }
    png_write_info(png, stream.info());
    const std::size_t row_bytes = static_cast<std::size_t>(width) * channels;
    for (std::size_t at = 0; at < pixels.size(); at += row_bytes)
        png_write_row(png, &pixels[at]);
    png_write_end(png, nullptr);
    return stream.take();
}

}  // namespace

void write_png(const Image& image, const Display& display, const fs::path& file)
{
    write_png(image, display, file, {});
}

void write_png(const Image& image, const Display& display, const fs::path& file,
               const std::vector<PngText>& texts)
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

    std::vector<unsigned char> bytes;
    try {
        bytes = encoded_png(image.width, image.height, stored, pixels, texts);
    } catch (const std::runtime_error& error) {
        throw Error(fmt::format("{}: cannot encode {} x {} pixels: {}; try a smaller picture",
                                file.string(), image.width, image.height, error.what()));
    }
    write_whole(file, bytes);
}

}  // namespace fumarole::write
