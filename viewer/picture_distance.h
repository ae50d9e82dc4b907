#pragma once

#include <limits>
#include <optional>
#include <string>

#include "study/metrics.h"
#include <fumarole/write/image_writer.h>

namespace fumarole::command {

/// How far a picture of a target is from its reference, by number and by eye.
struct PictureDistance {
    study::Metrics metrics;
    double flip = std::numeric_limits<double>::infinity();  ///< 0..1; infinite if not finite
    Display display;  ///< display transform that FLIP sees both through
};

/// How a target is shown: transmittance as it is, radiance through the filmic transform, at the
/// exposure asked for or the picture's own.
Display display_for(const std::string& target, const Image& image, std::optional<float> exposure);

/// Both R, G, B of one size. One exposure for both, the reference's own, so that a picture that is
/// too bright looks too bright. @throws Error as study::compare
PictureDistance picture_distance(const std::string& target, const Image& test,
                                 const Image& reference, std::optional<float> exposure);

}  // namespace fumarole::command
