#pragma once

#include <vector>

#include "prepared_frame.h"
#include "toolbox.h"

namespace fumarole::pass {

/// Which tiles of a frame's picture, StepTiles::kPictureTile pixels wide, are to have a ray for
/// each pixel and the mean of light over each step: those around a sun in view, or around the point
/// away from it, of media whose lobe changes within a texel, and those around a point light among
/// media. Row by row; empty: none.
std::vector<bool> fine_tiles(const Toolbox& tools, const PreparedFrame& frame);

}  // namespace fumarole::pass
