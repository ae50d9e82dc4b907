#pragma once

#include <array>
#include <cstdint>

#include "gl/texture.h"

namespace fumarole::pass {

inline constexpr int kBlueNoiseSize = 64;  ///< pixels along each side of the tile, which repeats

/// Ranks 0..4095, each once, rows of kBlueNoiseSize: neighbours get far-apart ranks, so that the
/// error of a march jittered by (rank + 0.5) / 4096 of a step is fine grain that an upsample or an
/// eye averages away (Ulichney 1993). The tile's edges match.
extern const std::array<std::uint16_t, std::size_t{kBlueNoiseSize} * kBlueNoiseSize> kBlueNoise;

/// The tile as a texture of (rank + 0.5) / 4096.
gl::Texture make_blue_noise(const gl::Device& device);

}  // namespace fumarole::pass
