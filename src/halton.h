#pragma once

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

}  // namespace fumarole
