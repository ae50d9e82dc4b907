// Linear Rec. 709 radiance in, display-encoded 0..1 out, and the exposure that suits a picture.
//
// Filmic is three published pieces, applied to radiance * 2^exposure_ev:
//   Hable 2010, Filmic Tonemapping Operators: the "Uncharted 2" curve, per channel, so that a
//     brightening flame turns from orange over yellow to white as film does;
//   Khronos 2024, PBR Neutral Tone Mapper: what the curve took from the brightest channel fades
//     the colour towards white, so that a pure primary, which a curve per channel leaves alone,
//     reaches white too;
//   IEC 61966-2-1: the sRGB encoding.
// Each output channel never falls when an input channel or the exposure rises.

#include <fumarole/write/image_writer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include <fmt/format.h>

#include "shared/filmic.h"
#include <fumarole/errors.h>

namespace fumarole::write {
namespace {

float hable(float x)
{
    return (x * (HABLE_A * x + HABLE_C * HABLE_B) + HABLE_D * HABLE_E) /
               (x * (HABLE_A * x + HABLE_B) + HABLE_D * HABLE_F) -
           HABLE_E / HABLE_F;
}

// 0 at 0, 1 at FILMIC_WHITE and above.
float filmic_curve(float radiance)
{
    static const float black = hable(0);  // 0 but for rounding, which a screen's blacks would show
    static const float white = hable(FILMIC_SCALE * FILMIC_WHITE) - black;
    const float mapped = (hable(FILMIC_SCALE * std::min(radiance, FILMIC_WHITE)) - black) / white;
    return std::clamp(mapped, 0.0f, 1.0f);
}

glm::vec3 filmic(glm::vec3 radiance)
{
    const float peak = std::max({radiance.r, radiance.g, radiance.b});
    const float mapped_peak = filmic_curve(peak);
    const float lost = std::max(0.0f, peak - mapped_peak);
    const float to_white = 1 - 1 / (FILMIC_DESATURATION * lost + 1);
    const glm::vec3 mapped(filmic_curve(radiance.r), filmic_curve(radiance.g),
                           filmic_curve(radiance.b));
    return mapped + to_white * (glm::vec3(mapped_peak) - mapped);
}

float srgb_encode(float linear)
{
    const float x = std::clamp(linear, 0.0f, 1.0f);
    return x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1 / 2.4f) - 0.055f;
}

// Luminance of each pixel that has a positive, finite one; the count of all others is the rest.
std::vector<float> lit_luminances(const Image& image)
{
    std::array<int, 3> rgb{};
    constexpr std::array<const char*, 3> kNames = {"R", "G", "B"};
    for (std::size_t i = 0; i < kNames.size(); ++i) {
        const auto found = std::find(image.channels.begin(), image.channels.end(), kNames[i]);
        if (found == image.channels.end()) {
            throw Error(fmt::format("auto exposure: the picture has no channel '{}'; give it R, G "
                                    "and B or set the exposure by hand",
                                    kNames[i]));
        }
        rgb[i] = static_cast<int>(found - image.channels.begin());
    }

    std::vector<float> lit;
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            const float luminance = 0.2126f * image.at(x, y, rgb[0]) +
                                    0.7152f * image.at(x, y, rgb[1]) +
                                    0.0722f * image.at(x, y, rgb[2]);
            if (luminance > 0 && std::isfinite(luminance)) {
                lit.push_back(luminance);
            }
        }
    }
    return lit;
}

}  // namespace

glm::vec3 display_transform(glm::vec3 radiance, const Display& display)
{
    const float scale = std::exp2(display.exposure_ev);
    for (int i = 0; i < 3; ++i) {
        // In this order a NaN (0 radiance times an infinite scale) becomes 0.
        radiance[i] = std::max(0.0f, radiance[i] * scale);
    }
    if (display.transform == Display::Transform::filmic) {
        radiance = filmic(radiance);
    }
    return {srgb_encode(radiance.r), srgb_encode(radiance.g), srgb_encode(radiance.b)};
}

// The smaller of two exposures: the one that brings the bright parts (a percentile) to white, and
// the one that brings the average to middle grey. So a bright haze is not blown out, and a small
// fire in the dark is not either: there the percentile decides. Light k times as strong gives an
// exposure log2(k) lower; a pixel made brighter never raises it.
float auto_exposure(const Image& image)
{
    // Below it lies all but a few stray pixels: a sun's disc, a firefly.
    constexpr double kBrightPercentile = 0.995;
    constexpr double kMiddleGrey = 0.18;
    // Stops under the bright parts at which a pixel counts as black and no darker; without it the
    // log-average would be the depth of the shadows.
    constexpr double kBlackStops = 6;

    std::vector<float> luminances = lit_luminances(image);
    if (luminances.empty()) {
        return 0;
    }
    const std::size_t pixels =
        static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    const std::size_t black = pixels - luminances.size();
    const auto rank = static_cast<std::size_t>(kBrightPercentile * static_cast<double>(pixels - 1));
    // With less lit than the percentile leaves over, the lit pixels are the picture.
    const std::size_t lit_rank =
        rank >= black ? rank - black
                      : static_cast<std::size_t>(kBrightPercentile *
                                                 static_cast<double>(luminances.size() - 1));
    // Sorted whole, so that the sum below has one order and one rounding everywhere.
    std::sort(luminances.begin(), luminances.end());
    const double bright_stops = std::log2(static_cast<double>(luminances[lit_rank]));

    const double black_stops = bright_stops - kBlackStops;
    double sum = static_cast<double>(black) * black_stops;
    for (const float luminance : luminances) {
        // Stray pixels are bounded too, as many as the percentile leaves over.
        sum += std::clamp(std::log2(static_cast<double>(luminance)), black_stops, bright_stops);
    }
    const double average_stops = sum / static_cast<double>(pixels);
    return static_cast<float>(std::min(-bright_stops, std::log2(kMiddleGrey) - average_stops));
}

}  // namespace fumarole::write
