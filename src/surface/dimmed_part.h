#pragma once

#include <optional>
#include <span>
#include <vector>

#include "prepared_frame.h"

namespace fumarole::surface {

/// Pixels from the lower left.
struct PictureBand {
    glm::ivec2 low{0}, size{0};
};

/// What of a picture may show a place of a surface whose light from suns has come through the
/// media: bands of rows, each as wide as what of it lies in one. A rasteriser without branches
/// looks optical depth up for all that it draws.
/// @param media what dims light lies in these bounds, metres, world
/// @param surface its bounds, likewise
/// @param to_suns unit length
/// @return none: all of it may
std::optional<std::vector<PictureBand>> dimmed_part(const PreparedFrame& frame, const Bounds& media,
                                                    const Bounds& surface,
                                                    std::span<const glm::dvec3> to_suns);

/// Likewise of places that lie in a box.
std::optional<std::vector<PictureBand>> part_within(const PreparedFrame& frame, const Bounds& box,
                                                    const Bounds& surface);

}  // namespace fumarole::surface
