#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "study/reference.h"

// The error of a whole picture from references of few of its pixels. They are drawn where pictures
// differ from a guide, a dear picture of the same scene, and what the guide says of all pixels is
// then corrected by what the references say of a few (a control variate: Owen 2013, "Monte Carlo
// theory, methods and examples", 8.9), so that a guide that errs makes the answer less sure and
// not wrong.

namespace fumarole::study {

/// A pixel, and how many pixels of the picture it stands for, over their number.
struct PixelDraw {
    std::size_t pixel = 0;
    double weight = 1;
};

/// relMSE's term of a pixel: mean over channels of (x - r)^2 / (r^2 + floor).
/// @param floor 0.1 mean(r^2) over all pixels and channels
double pixel_error(const float* x, const float* r, double floor);

/// Where to draw: a chance for each pixel, with the sum 1. Most of it where a picture is off the
/// guide, the rest at edges and evenly.
/// @param guide RGB, rows of `width` pixels
std::vector<double> drawing_density(std::span<const float> guide, std::size_t width,
                                    std::span<const float> look, double floor);

/// Batch after batch, each alone a fair sample: one draw at random in each of equal parts of the
/// chances. (At equal distances they would fall into step with the picture's rows.)
std::vector<PixelDraw> draw_pixels(std::span<const double> density, int batches, int batch_size);

/// Mean over the picture of a quantity, from its draws.
struct Estimate {
    double value = 0;
    double deviation = 0;  ///< one standard error
};

/// @param known of each draw, weighted: what is asked for
/// @param guessed of each draw, weighted: something like it, whose mean over all is `guess`
Estimate controlled_mean(std::span<const double> known, std::span<const double> guessed,
                         double guess);

/// Root of an estimated relMSE, and one standard error above.
struct RootError {
    double error = 0, surely = 0;
};

/// References of drawn pixels, as many as time allows, and the errors that follow from them.
class SparseReference {
public:
    /// @param guide RGB, rows from the top
    /// @param bounces, surface_bounces of the references, as in ReferenceOptions
    SparseReference(const Scene& scene, std::vector<float> guide, double tolerance, int bounces,
                    int surface_bounces, const std::atomic<bool>* cancel);

    /// 0.1 mean(r^2), by the guide.
    [[nodiscard]] double floor() const { return guide_floor_; }
    [[nodiscard]] std::span<const float> guide() const { return guide_; }
    [[nodiscard]] const Reference& reference() const { return *reference_; }
    [[nodiscard]] double tolerance() const { return tolerance_; }

    void set_draws(std::vector<PixelDraw> draws) { draws_ = std::move(draws); }
    /// Works out the references of some draws. @throws ReferenceCancelled
    void refer(std::span<const std::size_t> draws);
    /// Starts anew with references as exact as this.
    void set_tolerance(double tolerance);

    /// What is kept of a picture.
    struct Look {
        double from_guide = 0;      ///< its relMSE, the guide taken for the reference
        std::vector<float> values;  ///< RGB of each draw
    };
    [[nodiscard]] Look look(std::span<const float> picture) const;

    /// By some draws, which must have been referred to.
    [[nodiscard]] RootError error(const Look& look, std::span<const std::size_t> draws) const;

    [[nodiscard]] std::size_t pixels_known() const { return known_.size(); }

private:
    const Scene& scene_;
    const std::atomic<bool>* cancel_;
    std::vector<float> guide_;
    double guide_floor_ = 0, tolerance_;
    std::unique_ptr<Reference> reference_;
    std::vector<PixelDraw> draws_;
    struct Known {
        glm::vec3 rgb, with_noise;  ///< the same with a noise that it may have
    };
    std::unordered_map<std::size_t, Known> known_;
    int bounces_, surface_bounces_;
};

}  // namespace fumarole::study
