#pragma once

#include <cmath>
#include <cstdint>

namespace fumarole {

/// Halton 1964: the digits of n in `base`, mirrored about the point: 0..1, evenly filled by n = 0,
/// 1, 2, ...
inline double radical_inverse(std::uint64_t n, unsigned base)
{
    double value = 0, digit = 1.0 / base;
    for (; n > 0; n /= base, digit /= base)
        value += digit * static_cast<double>(n % base);
    return value;
}

/// The fraction of n golden ratios: 0..1, evenly filled by n = 0, 1, 2, ... (Roberts 2018's points
/// on a line).
inline double golden_fraction(double n)
{
    constexpr double kGolden = 0.6180339887498949;
    return kGolden * n - std::floor(kGolden * n);
}

}  // namespace fumarole
