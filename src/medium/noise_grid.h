#pragma once

#include <memory>

#include <fumarole/bounds.h>
#include <fumarole/scene.h>

namespace fumarole::medium {

/// What trilinear interpolation between a noise grid's nodes is allowed to err: RMS, relative to
/// the RMS of the octaves' sum.
inline constexpr double kNoiseGridError = 0.02;

/// The coefficient of a noise that does not drift at nodes over `bounds`, in metres: the first and
/// the last along each axis lie on its faces, and bounds' is where the grid is to end. Nothing
/// where more nodes are needed than a few tens of MB hold, or than `longest` along an axis.
std::shared_ptr<const VoxelGrid> make_noise_grid(const NoiseProfile& noise, const Bounds& bounds,
                                                 int longest);

}  // namespace fumarole::medium
