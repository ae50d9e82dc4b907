#pragma once

#include "asset/json_reader.h"

// What the numbers of a scene file may be.

namespace fumarole::asset {

// No scene needs more, and squares and products of these stay finite in 32-bit floats too.
inline constexpr double kMaxMetres = 1e12;
inline constexpr double kMaxValue = 1e12;

inline constexpr NumberRange kCoordinate{-kMaxMetres, kMaxMetres, false, false, "metres"};
inline constexpr NumberRange kLength{0, kMaxMetres, true, false, "metres"};
inline constexpr NumberRange kLengthOrNone{0, kMaxMetres, false, false, "metres"};
inline constexpr NumberRange kDirection{-kMaxValue, kMaxValue};
inline constexpr NumberRange kScale{0, kMaxValue, true, false};
inline constexpr NumberRange kCoefficient{0, kMaxValue, false, false, "1/m"};
inline constexpr NumberRange kRadiance{0, kMaxValue, false, false, "W/m^2/sr"};
inline constexpr NumberRange kEmission{0, kMaxValue, false, false, "W/m^2/sr per metre"};
inline constexpr NumberRange kKelvin{0, kMaxValue, true, false, "kelvin per unit"};
inline constexpr NumberRange kFactor{0, kMaxValue};
inline constexpr NumberRange kAlbedo{0, 1};
inline constexpr NumberRange kShare{0, 1};
inline constexpr NumberRange kAnisotropy{-1, 1, true, true};
inline constexpr NumberRange kAngle{0, 180, true, true, "degrees"};
inline constexpr NumberRange kTime{-kMaxValue, kMaxValue, false, false, "seconds"};
inline constexpr NumberRange kRate{0, 1e6, true, false, "1/s"};
inline constexpr NumberRange kShutter{0, 100, false, false, "frames"};
inline constexpr NumberRange kSpeed{-kMaxValue, kMaxValue, false, false, "m/s"};
// Sixteen octaves of a larger one would leave the range in which doubles tell lattice cells apart.
inline constexpr NumberRange kLacunarity{1, 16};

}  // namespace fumarole::asset
