#pragma once

#include <span>
#include <vector>

#include <fumarole/write/image_writer.h>

namespace fumarole::study {

/// The paper's viewer: 0.7 m from a screen 0.7 m and 3840 pixels wide; 0.7 * 3840 / 0.7 * pi / 180.
inline constexpr float kFlipPixelsPerDegree = 67.0206f;

/// How different two pictures look when one is flicked to the other in place: 0 the same, 1 the
/// most that a screen can do.
struct Flip {
    std::vector<float> map;  ///< one value a pixel, rows from the top, 0..1
    double mean = 0;         ///< mean of the map, 0..1
};

/// LDR-FLIP of display-encoded sRGB pictures, three interleaved channels, what is outside 0..1 cut
/// as a screen cuts it. Exchanging the pictures changes nothing. `pixels_per_degree` is of the
/// viewer's eye: larger is farther away. @throws Error if the sizes do not fit or are empty, if a
/// value is NaN, or if pixels_per_degree is not in 4..1000.
Flip flip(std::span<const float> test, std::span<const float> reference, int width, int height,
          float pixels_per_degree = kFlipPixelsPerDegree);

/// The same of linear radiance, as a screen would show both through one display transform and one
/// exposure. It judges what is seen at that exposure; it is not HDR-FLIP, which looks for the worst
/// of all exposures.
Flip flip_of_radiance(std::span<const float> test, std::span<const float> reference, int width,
                      int height, const Display& display,
                      float pixels_per_degree = kFlipPixelsPerDegree);

}  // namespace fumarole::study
