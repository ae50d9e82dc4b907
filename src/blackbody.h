#pragma once

#include <algorithm>
#include <numbers>

#include "shared/blackbody.h"

// How bright a medium is that glows as a blackbody does, in the units that Blender's Principled
// Volume has made known. Its colour has luminance 1: glsl/shared/blackbody.h.

namespace fumarole {

/// The radiance that 1000 K and an intensity of 1 add per metre, over W/m^2/sr: sigma T^4 / pi
/// (Stefan and Boltzmann; sigma by CODATA 2018), a millionth of it as in Principled Volume, whose
/// unit of a flame's radiance so is 1 MW/m^2/sr.
inline constexpr double kBlackbodyOfKilokelvin = 5.670374419e-8 * 1e12 * 1e-6 / std::numbers::pi;

/// Kelvin of what begins to be seen.
inline const double kDarkKelvin = 1000.0 * static_cast<double>(shared::kDarkKilokelvin);
inline const double kDraperKelvin = 1000.0 * static_cast<double>(shared::kDraperKilokelvin);

/// Kelvin that a unit of a grid of temperatures stands for, by its largest value: no simulator that
/// counts in kelvin has a domain so cold, none that doesn't flames so hot.
inline double guess_kelvin_per_unit(double largest)
{
    constexpr double kMostUnits = 20;
    return largest < kMostUnits ? 1000 : 1;
}

/// The luminance that a metre at a temperature adds, at an intensity of 1. [W/m^2/sr per metre]
inline double blackbody_luminance(double kelvin)
{
    const double t =
        std::clamp(kelvin / 1000, 0.0, static_cast<double>(shared::kHottestKilokelvin));
    const double u = std::clamp((1000 * t - kDarkKelvin) / (kDraperKelvin - kDarkKelvin), 0.0, 1.0);
    return kBlackbodyOfKilokelvin * t * t * t * t * u * u * (3 - 2 * u);
}

}  // namespace fumarole
