// Numbers to colours, with the scale that makes numbers of them again.

#include "study/false_color.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include <fmt/format.h>

#include "scale_end.h"
#include "shared/magma.h"
#include "study/label_font.h"
#include "study/metrics.h"
#include "study/srgb.h"
#include <fumarole/errors.h>

namespace fumarole::study {
namespace {

using Rgb8 = std::array<std::uint8_t, 3>;

#define RGB8(r, g, b)                                                                              \
    {                                                                                              \
        r, g, b                                                                                    \
    }
constexpr std::array<Rgb8, MAGMA_COUNT> kMagma = {{MAGMA(RGB8)}};
#undef RGB8

// In CIELAB: L* = 50 + 38 t, hue 285 degrees below 0 and 80 above, chroma min(70 |t|^0.75, what
// sRGB holds). A map that is light in the middle or at both ends would lose the sign when printed
// grey.
constexpr std::array<Rgb8, 9> kDiverging = {{{0x01, 0x1f, 0x46},
                                             {0x04, 0x32, 0x6b},
                                             {0x22, 0x47, 0x88},
                                             {0x53, 0x5e, 0x86},
                                             {0x77, 0x77, 0x77},
                                             {0xa6, 0x8b, 0x65},
                                             {0xcb, 0xa2, 0x5e},
                                             {0xf0, 0xb9, 0x58},
                                             {0xfe, 0xd7, 0x9c}}};

constexpr glm::vec3 kPaper(1);
constexpr glm::vec3 kInk(0);
constexpr glm::vec3 kNotANumber(0, 1, 0);

// Between the colours as they are encoded, where equal steps look equal.
template <std::size_t N> glm::vec3 look_up(const std::array<Rgb8, N>& table, float t)
{
    const float position = std::clamp(t, 0.0f, 1.0f) * static_cast<float>(N - 1);
    const std::size_t below = std::min(static_cast<std::size_t>(position), N - 2);
    const float fraction = position - static_cast<float>(below);
    glm::vec3 color;
    for (std::size_t c = 0; c < 3; ++c) {
        const auto low = static_cast<float>(table[below][c]);
        const auto high = static_cast<float>(table[below + 1][c]);
        color[static_cast<int>(c)] = srgb_decode((low + (high - low) * fraction) / 255);
    }
    return color;
}

void put(Image& image, int x, int y, glm::vec3 color)
{
    const std::size_t pixel =
        3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
             static_cast<std::size_t>(x));
    std::copy_n(&color.x, 3, image.pixels.begin() + static_cast<std::ptrdiff_t>(pixel));
}

// Three digits; a thousand percent and more is easier read without an exponent.
std::string percent(double value)
{
    const double size = std::abs(value) * 100;
    return size >= 1000 && size < 1e6 ? fmt::format("{:.0f}%", value * 100)
                                      : fmt::format("{:.3g}%", value * 100);
}

double largest_of(std::span<const float> map)
{
    double largest = 0;
    for (const float value : map) {
        if (std::isfinite(value) && std::abs(static_cast<double>(value)) > std::abs(largest)) {
            largest = static_cast<double>(value);
        }
    }
    return largest;
}

constexpr int kTicks = 5;  // quarters of 1, 2 and 4 have at most three digits

}  // namespace

std::vector<float> difference_map(std::span<const float> x, std::span<const float> r, int channels,
                                  Difference difference)
{
    const auto stride = static_cast<std::size_t>(std::max(channels, 1));
    if (channels < 1 || x.size() != r.size() || x.size() % stride != 0) {
        throw Error(fmt::format("no difference picture of {} and {} values of {} channels; give "
                                "two pictures of one size",
                                x.size(), r.size(), channels));
    }
    // relMSE's own floor.
    double sum_square = 0;
    for (const float value : r) {
        sum_square += static_cast<double>(value) * static_cast<double>(value);
    }
    const double floor =
        0.1 * sum_square / static_cast<double>(std::max<std::size_t>(r.size(), 1)) + kTinySquare;

    std::vector<float> map(x.size() / stride);
    for (std::size_t pixel = 0; pixel < map.size(); ++pixel) {
        double sum = 0;
        for (std::size_t i = pixel * stride; i < (pixel + 1) * stride; ++i) {
            const auto reference = static_cast<double>(r[i]);
            const double error =
                (static_cast<double>(x[i]) - reference) / std::sqrt(reference * reference + floor);
            sum += difference == Difference::magnitude ? error * error : error;
        }
        const double mean = sum / static_cast<double>(stride);
        const double value = difference == Difference::magnitude ? std::sqrt(mean) : mean;
        map[pixel] = std::isfinite(value) ? static_cast<float>(value)
                                          : std::numeric_limits<float>::quiet_NaN();
    }
    return map;
}

double difference_scale(std::span<const float> map)
{
    constexpr double kWithin = 0.99;
    constexpr double kSmallest = 1e-6;
    std::vector<double> sizes;
    for (const float value : map) {
        if (std::isfinite(value)) {
            sizes.push_back(std::abs(static_cast<double>(value)));
        }
    }
    if (sizes.empty()) {
        return kSmallest;
    }
    const auto rank = static_cast<std::ptrdiff_t>(kWithin * static_cast<double>(sizes.size() - 1));
    std::nth_element(sizes.begin(), sizes.begin() + rank, sizes.end());
    return scale_end(std::max(sizes[static_cast<std::size_t>(rank)], kSmallest));
}

glm::vec3 difference_color(float t, Difference difference)
{
    return difference == Difference::magnitude ? look_up(kMagma, t)
                                               : look_up(kDiverging, 0.5f * (t + 1));
}

Image with_color_bar(const Image& picture, Difference palette, std::span<const std::string> ticks,
                     const std::string& caption)
{
    const int width = picture.width, height = picture.height;
    const int steps = static_cast<int>(ticks.size()) - 1;
    constexpr int kTextUnit = 480;  // picture width [pixels] that letters of scale 1 are read at
    const int unit = std::max(1, width / kTextUnit);
    int label_space = 0;
    for (const std::string& label : ticks) {
        label_space = std::max(label_space, label_width(label, unit));
    }
    const int gap = 4 * unit;
    const int bar_height = 12 * unit;
    const int tick_length = 3 * unit;
    const int line = label_height(unit);
    // Half a label stands out at either end of the bar.
    const int inset = label_space / 2 + gap;
    const int needed =
        std::max(2 * inset + steps * (label_space + gap), label_width(caption, unit) + 2 * gap);

    Image image;
    image.width = std::max(width, needed);
    image.height = height + gap + bar_height + tick_length + unit + line + gap + line + gap;
    image.channels = {"R", "G", "B"};
    image.pixels.assign(3 * static_cast<std::size_t>(image.width) *
                            static_cast<std::size_t>(image.height),
                        kPaper.x);

    const int left = (image.width - width) / 2;
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            put(image, left + x, y,
                {picture.at(x, y, 0), picture.at(x, y, 1), picture.at(x, y, 2)});
        }
    }

    const int bar_top = height + gap;
    const int bar_width = image.width - 2 * inset;
    const double first = palette == Difference::magnitude ? 0 : -1;
    for (int x = 0; x < bar_width; ++x) {
        const double along = static_cast<double>(x) / static_cast<double>(bar_width - 1);
        const double t = first + (1 - first) * along;
        const glm::vec3 color = difference_color(static_cast<float>(t), palette);
        for (int y = 0; y < bar_height; ++y) {
            const bool outline = x == 0 || y == 0 || x == bar_width - 1 || y == bar_height - 1;
            put(image, inset + x, bar_top + y, outline ? kInk : color);
        }
    }
    const int label_top = bar_top + bar_height + tick_length + unit;
    for (int i = 0; i <= steps; ++i) {
        const int x = inset + (bar_width - 1) * i / steps;
        for (int y = 0; y < tick_length; ++y) {
            put(image, x, bar_top + bar_height + y, kInk);
        }
        const std::string& label = ticks[static_cast<std::size_t>(i)];
        draw_label(image, x - label_width(label, unit) / 2, label_top, label, kInk, unit);
    }
    draw_label(image, (image.width - label_width(caption, unit)) / 2, label_top + line + gap,
               caption, kInk, unit);
    return image;
}

Image false_color(std::span<const float> map, int width, int height, const FalseColor& style)
{
    if (width < 1 || height < 1 ||
        map.size() != static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {
        throw Error(fmt::format("no false-colour picture of {} x {} pixels from {} values", width,
                                height, map.size()));
    }
    if (!(style.scale > 0) || !std::isfinite(style.scale)) {
        throw Error(fmt::format("a false-colour scale of {} has no colours; give one above 0",
                                style.scale));
    }

    const double first = style.difference == Difference::magnitude ? 0 : -style.scale;
    std::array<std::string, kTicks> labels;
    for (std::size_t i = 0; i < labels.size(); ++i) {
        labels[i] = percent(first + (style.scale - first) * static_cast<double>(i) / (kTicks - 1));
    }
    std::string caption = style.caption.empty() ? "" : style.caption + "  ";
    caption += "largest " + percent(largest_of(map));
    const auto broken =
        std::count_if(map.begin(), map.end(), [](float value) { return !std::isfinite(value); });
    if (broken > 0) {
        caption += fmt::format("  not finite {} (green)", broken);
    }

    Image colors{width, height, {"R", "G", "B"}, {}};
    for (const float value : map) {
        const double t = static_cast<double>(value) / style.scale;
        const glm::vec3 color = std::isfinite(value)
                                    ? difference_color(static_cast<float>(t), style.difference)
                                    : kNotANumber;
        colors.pixels.insert(colors.pixels.end(), {color.r, color.g, color.b});
    }
    return with_color_bar(colors, style.difference, labels, caption);
}

}  // namespace fumarole::study
