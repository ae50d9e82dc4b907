#include "study/plan_error.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <oneapi/tbb/parallel_for.h>
#include <random>

#include "study/metrics.h"

namespace fumarole::study {

namespace {

/// Of the draws: what goes evenly over the picture, and what to its edges, for errors that the
/// guide shares (a silhouette that all pictures have a fraction of a pixel off).
constexpr double kEvenShare = 0.25, kEdgeShare = 0.15;

/// As in relMSE (metrics.h).
constexpr double kDarkShare = 0.1;

double mean(std::span<const double> values)
{
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

}  // namespace

double pixel_error(const float* x, const float* r, double floor)
{
    double sum = 0;
    for (int c = 0; c < 3; ++c) {
        const double reference = r[c], off = x[c] - reference;
        sum += off * off / (reference * reference + floor);
    }
    return sum / 3;
}

std::vector<double> drawing_density(std::span<const float> guide, std::size_t width,
                                    std::span<const float> look, double floor)
{
    const std::size_t pixels = guide.size() / 3;
    std::vector<double> density(pixels, kEvenShare / static_cast<double>(pixels));
    const auto add = [&](double share, const auto& weight) {
        std::vector<double> weights(pixels);
        for (std::size_t i = 0; i < pixels; ++i)
            weights[i] = weight(i);
        const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
        const bool usable = sum > 0 && std::isfinite(sum);
        for (std::size_t i = 0; i < pixels; ++i)
            density[i] += share * (usable ? weights[i] / sum : 1 / static_cast<double>(pixels));
    };
    const auto apart = [&](const float* a, const float* b) {
        return std::sqrt(pixel_error(a, b, floor));
    };
    add(kEdgeShare, [&](std::size_t i) {
        const float* here = &guide[i * 3];
        double most = 0;
        if (i % width > 0)
            most = apart(here - 3, here);
        if (i % width + 1 < width)
            most = std::max(most, apart(here + 3, here));
        if (i >= width)
            most = std::max(most, apart(here - 3 * width, here));
        if (i + width < pixels)
            most = std::max(most, apart(here + 3 * width, here));
        return most;
    });
    add(1 - kEvenShare - kEdgeShare,
        [&](std::size_t i) { return apart(&look[i * 3], &guide[i * 3]); });
    return density;
}

std::vector<PixelDraw> draw_pixels(std::span<const double> density, int batches, int batch_size)
{
    std::vector<PixelDraw> draws;
    const double pixels = static_cast<double>(density.size());
    std::mt19937 random;  // the same pixels every time
    for (int batch = 0; batch < batches; ++batch) {
        std::size_t pixel = 0;
        double up_to = density[0];
        for (int i = 0; i < batch_size; ++i) {
            const double at = (i + static_cast<double>(random()) * 0x1p-32) / batch_size;
            while (up_to < at && pixel + 1 < density.size())
                up_to += density[++pixel];
            draws.push_back({pixel, 1 / (pixels * density[pixel])});
        }
    }
    return draws;
}

Estimate controlled_mean(std::span<const double> known, std::span<const double> guessed,
                         double guess)
{
    const double n = static_cast<double>(known.size());
    const double mean_known = mean(known), mean_guessed = mean(guessed);
    double together = 0, spread = 0;
    for (std::size_t i = 0; i < known.size(); ++i) {
        together += (known[i] - mean_known) * (guessed[i] - mean_guessed);
        spread += (guessed[i] - mean_guessed) * (guessed[i] - mean_guessed);
    }
    const double trust = spread > 0 ? std::clamp(together / spread, 0.0, 1.0) : 0;
    Estimate estimate{mean_known + trust * (guess - mean_guessed), 0};
    double squares = 0;
    for (std::size_t i = 0; i < known.size(); ++i) {
        const double rest = known[i] - mean_known - trust * (guessed[i] - mean_guessed);
        squares += rest * rest;
    }
    estimate.deviation = n > 1 ? std::sqrt(squares / (n - 1) / n) : estimate.value;
    return estimate;
}

SparseReference::SparseReference(const Scene& scene, std::vector<float> guide, double tolerance,
                                 int bounces, int surface_bounces, const std::atomic<bool>* cancel)
    : scene_{scene}, cancel_{cancel}, guide_{std::move(guide)}, tolerance_{tolerance},
      reference_{std::make_unique<Reference>(scene, tolerance, bounces, surface_bounces, cancel)},
      bounces_{bounces}, surface_bounces_{surface_bounces}
{
    double squares = 0;
    for (const float v : guide_)
        squares += static_cast<double>(v) * v;
    guide_floor_ = kDarkShare * squares / static_cast<double>(guide_.size()) + kTinySquare;
}

void SparseReference::set_tolerance(double tolerance)
{
    tolerance_ = tolerance;
    known_.clear();
    reference_ =
        std::make_unique<Reference>(scene_, tolerance, bounces_, surface_bounces_, cancel_);
}

void SparseReference::refer(std::span<const std::size_t> draws)
{
    std::vector<std::size_t> pixels;
    for (const std::size_t i : draws)
        if (known_.find(draws_[i].pixel) == known_.end())
            pixels.push_back(draws_[i].pixel);
    std::sort(pixels.begin(), pixels.end());
    pixels.erase(std::unique(pixels.begin(), pixels.end()), pixels.end());
    std::vector<Known> found(pixels.size());
    const double good_enough = tolerance_ * std::sqrt(guide_floor_);
    oneapi::tbb::parallel_for(std::size_t{0}, pixels.size(), [&](std::size_t i) {
        if (cancel_ != nullptr && *cancel_)
            throw ReferenceCancelled();
        const std::size_t width = scene_.resolution.x;
        const glm::dvec2 corner(pixels[i] % width, pixels[i] / width);
        const ReferenceSample s = reference_->sample(corner + 0.5, good_enough);
        found[i] = {glm::vec3(s.composite), glm::vec3(s.composite + s.composite_noise)};
    });
    for (std::size_t i = 0; i < pixels.size(); ++i)
        known_.emplace(pixels[i], found[i]);
}

SparseReference::Look SparseReference::look(std::span<const float> picture) const
{
    Look look;
    const std::size_t pixels = guide_.size() / 3;
    for (std::size_t i = 0; i < pixels; ++i)
        look.from_guide += pixel_error(&picture[i * 3], &guide_[i * 3], guide_floor_) /
                           static_cast<double>(pixels);
    for (const PixelDraw& draw : draws_)
        for (std::size_t c = 0; c < 3; ++c)
            look.values.push_back(picture[draw.pixel * 3 + c]);
    return look;
}

RootError SparseReference::error(const Look& look, std::span<const std::size_t> draws) const
{
    // The floor by the references, the guide's own as its control.
    std::vector<double> known, guessed;
    const auto square = [](const float* v) {
        return (static_cast<double>(v[0]) * v[0] + static_cast<double>(v[1]) * v[1] +
                static_cast<double>(v[2]) * v[2]) /
               3;
    };
    for (const std::size_t i : draws) {
        known.push_back(draws_[i].weight * square(&known_.at(draws_[i].pixel).rgb.x));
        guessed.push_back(draws_[i].weight * square(&guide_[draws_[i].pixel * 3]));
    }
    const double floor = std::max(
        kTinySquare, kDarkShare * controlled_mean(known, guessed, guide_floor_ / kDarkShare).value);
    known.clear();
    guessed.clear();
    for (const std::size_t i : draws) {
        const float* x = &look.values[i * 3];
        const Known& r = known_.at(draws_[i].pixel);
        known.push_back(draws_[i].weight * (pixel_error(x, &r.rgb.x, floor) -
                                            pixel_error(&r.with_noise.x, &r.rgb.x, floor)));
        guessed.push_back(draws_[i].weight *
                          pixel_error(x, &guide_[draws_[i].pixel * 3], guide_floor_));
    }
    const Estimate relmse = controlled_mean(known, guessed, look.from_guide);
    const double value = std::max(relmse.value, 0.0);
    return {std::sqrt(value), std::sqrt(value + relmse.deviation)};
}

}  // namespace fumarole::study
