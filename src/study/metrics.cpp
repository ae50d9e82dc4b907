// Metrics of DESIGN.md, with the guards against 0/0 of shared/reference/metrics.py: both must give
// the same numbers, so that figures of either can stand in one table.

#include "study/metrics.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include <fmt/format.h>

#include <fumarole/errors.h>

namespace fumarole::study {
namespace {

// metrics.py's: a pixel black in both, or a reference whose mean is 0, divides by these.
constexpr double kTinySum = 1e-6;
constexpr double kTinyMean = 1e-12;

constexpr double kHighQuantile = 0.999;

// numpy.quantile's default: linear between the two nearest ranks. Reorders `values`.
double quantile(std::vector<double>& values, double q)
{
    const double position = q * static_cast<double>(values.size() - 1);
    const auto below = static_cast<std::size_t>(position);
    const double fraction = position - static_cast<double>(below);
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(below);
    std::nth_element(values.begin(), at, values.end());
    if (fraction == 0) {
        return *at;
    }
    const double above = *std::min_element(at + 1, values.end());
    return *at + (above - *at) * fraction;
}

void check_lengths(std::size_t x, std::size_t r)
{
    if (x != r) {
        throw Error(fmt::format("cannot compare pictures of {} and {} values; render both at one "
                                "size with the same channels",
                                x, r));
    }
    if (x == 0) {
        throw Error("cannot compare pictures without a pixel; keep at least one");
    }
}

}  // namespace

Metrics compare(std::span<const float> x, std::span<const float> r)
{
    check_lengths(x.size(), r.size());
    const auto is_finite = [](float value) { return std::isfinite(value); };
    const auto broken = std::find_if_not(r.begin(), r.end(), is_finite);
    if (broken != r.end()) {
        throw Error(fmt::format("value {} of the reference is {}; nothing can be measured against "
                                "it, make the reference again",
                                broken - r.begin(), *broken));
    }

    Metrics metrics;
    if (!std::all_of(x.begin(), x.end(), is_finite)) {
        constexpr double kInfinity = std::numeric_limits<double>::infinity();
        return {.finite = false,
                .relmse = kInfinity,
                .smape = kInfinity,
                .bias = kInfinity,
                .p999 = kInfinity};
    }

    const auto count = static_cast<double>(x.size());
    double sum = 0;
    double sum_square = 0;
    for (const float value : r) {
        sum += static_cast<double>(value);
        sum_square += static_cast<double>(value) * static_cast<double>(value);
    }
    const double mean = std::max(sum / count, kTinyMean);
    const double floor = 0.1 * sum_square / count + kTinySquare;

    std::vector<double> errors(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) {
        const auto value = static_cast<double>(x[i]);
        const auto reference = static_cast<double>(r[i]);
        const double error = value - reference;
        errors[i] = std::abs(error);
        metrics.bias += error;
        metrics.relmse += error * error / (reference * reference + floor);
        metrics.smape += 2 * errors[i] / (std::abs(value) + std::abs(reference) + kTinySum);
    }
    metrics.relmse /= count;
    metrics.smape /= count;
    metrics.bias /= count * mean;
    metrics.p999 = quantile(errors, kHighQuantile) / mean;
    return metrics;
}

NoiseShare noise_relmse(std::span<const float> noise, std::span<const float> r)
{
    if (noise.empty())
        return {};
    check_lengths(noise.size(), r.size());
    const auto count = static_cast<double>(r.size());
    double sum_square = 0;
    for (const float value : r)
        sum_square += static_cast<double>(value) * static_cast<double>(value);
    const double floor = 0.1 * sum_square / count + kTinySquare;
    double sum = 0, squares = 0;
    for (std::size_t i = 0; i < r.size(); ++i) {
        const auto reference = static_cast<double>(r[i]), off = static_cast<double>(noise[i]);
        const double share = off * off / (reference * reference + floor);
        sum += share;
        squares += share * share;
    }
    // The error's own part, and that of a pixel's channels, which are as one sample.
    constexpr double kParts = 2, kChannels = 3;
    return {sum / count, std::sqrt(kParts * kChannels * squares) / count};
}

Metrics compare(std::span<const float> x, std::span<const float> r,
                std::span<const std::uint8_t> keep, int channels)
{
    check_lengths(x.size(), r.size());
    if (channels < 1 || keep.size() * static_cast<std::size_t>(channels) != x.size()) {
        throw Error(fmt::format("cannot keep {} pixels of {} channels out of {} values; the mask "
                                "must have the pictures' size",
                                keep.size(), channels, x.size()));
    }
    std::vector<float> kept_x;
    std::vector<float> kept_r;
    for (std::size_t pixel = 0; pixel < keep.size(); ++pixel) {
        if (keep[pixel] != 0) {
            const auto stride = static_cast<std::size_t>(channels);
            const auto of_x = x.subspan(pixel * stride, stride);
            const auto of_r = r.subspan(pixel * stride, stride);
            kept_x.insert(kept_x.end(), of_x.begin(), of_x.end());
            kept_r.insert(kept_r.end(), of_r.begin(), of_r.end());
        }
    }
    return compare(kept_x, kept_r);
}

}  // namespace fumarole::study
