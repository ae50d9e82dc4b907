#pragma once

#include <cmath>

namespace fumarole {

/// The smallest of 1, 2 or 4 times a power of ten that is not less than `size`: a scale's end whose
/// quarters read well. size > 0
inline double scale_end(double size)
{
    const double power = std::pow(10.0, std::floor(std::log10(size)));
    // A hair of rounding must not turn 1e-6 into 2e-6.
    constexpr double kHair = 1 + 1e-9;
    for (const double step : {1.0, 2.0, 4.0})
        if (size <= step * power * kHair)
            return step * power;
    return 10 * power;
}

}  // namespace fumarole
