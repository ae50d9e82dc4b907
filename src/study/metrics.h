#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

namespace fumarole::study {

/// What relMSE adds to its denominator: that of a reference that is black everywhere.
inline constexpr double kTinySquare = 1e-20;

/// Distance of a picture x from its reference r, over all channels of all pixels, linear values.
struct Metrics {
    bool finite = true;  ///< false if x has a NaN or an infinity: then the rest is infinite
    double relmse = 0;   ///< mean((x-r)^2 / (r^2 + 0.1 * mean(r^2)))
    double smape = 0;    ///< mean(2 |x-r| / (|x| + |r|))
    double bias = 0;     ///< mean(x-r) / mean(r), signed
    double p999 = 0;     ///< 99.9th percentile of |x-r|, over mean(r)
};

/// x and r have the same length. @throws Error if they have not, if they are empty, or if the
/// reference is not finite.
Metrics compare(std::span<const float> x, std::span<const float> r);

/// What a reference's own noise adds to the relMSE of any picture that is compared with it, and by
/// how much that is unsure (one standard error). `noise` is as ReferenceStill's; {} of a reference
/// that has none.
struct NoiseShare {
    double relmse = 0, deviation = 0;
    /// A relMSE without it; what is no larger than the deviation is not told from nothing.
    [[nodiscard]] double off(double measured) const
    {
        return relmse == 0 ? measured : std::max(measured - relmse, deviation);
    }
};
NoiseShare noise_relmse(std::span<const float> noise, std::span<const float> r);

/// The same over the pixels whose `keep` is not 0, e.g. without depth edges; `keep` has one entry a
/// pixel, x and r have `channels` values a pixel, interleaved. What is not kept may be NaN.
/// @throws Error as above, and if no pixel is kept.
Metrics compare(std::span<const float> x, std::span<const float> r,
                std::span<const std::uint8_t> keep, int channels);

}  // namespace fumarole::study
