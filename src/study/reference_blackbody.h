#pragma once

#include <glm/glm.hpp>

// What a medium emits that glows as a blackbody does (docs/scene_files.md): Planck's law seen by
// the CIE 1931 standard observer, summed over its table.

namespace fumarole::study {

/// CIE XYZ of a blackbody, Y = 1.
glm::dvec3 planck_xyz(double kelvin);

/// Linear Rec. 709 (ITU-R BT.709: its primaries, its white D65) of XYZ.
glm::dvec3 rec709_from_xyz(glm::dvec3 xyz);

/// Linear Rec. 709 of a blackbody, of luminance 1; a channel outside the gamut is 0.
/// @param kelvin 800 K to 40,000 K; beyond, the end's colour
glm::dvec3 blackbody_color(double kelvin);

/// What an intensity of 1 emits per metre. [W/m^2/sr per metre]
glm::dvec3 blackbody_emission(double kelvin);

}  // namespace fumarole::study
