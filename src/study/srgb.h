#pragma once

#include <algorithm>
#include <cmath>

namespace fumarole::study {

/// IEC 61966-2-1: what a screen makes of an encoded value. Outside 0..1 it shows 0 or 1.
inline float srgb_decode(float encoded)
{
    const float x = std::clamp(encoded, 0.0f, 1.0f);
    return x <= 0.04045f ? x / 12.92f : std::pow((x + 0.055f) / 1.055f, 2.4f);
}

}  // namespace fumarole::study
