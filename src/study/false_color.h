#pragma once

#include <span>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include <fumarole/write/image_writer.h>

namespace fumarole::study {

/// Which end of a difference matters.
enum class Difference {
    magnitude,  ///< how far off, 0 and up: black over violet and orange to pale yellow
    sign        ///< too dark or too bright: dark blue over grey to pale orange
};

/// The difference of each pixel of x from the reference r, three or any number of interleaved
/// channels, in the unit of relMSE's root: a channel's error over sqrt(r^2 + 0.1 mean(r^2)).
/// `magnitude` is the root of the mean square over the channels, so the map's own mean square is
/// relMSE; `sign` is the mean over the channels. NaN where x is not finite. x, r and channels fit
/// each other, r is finite.
std::vector<float> difference_map(std::span<const float> x, std::span<const float> r, int channels,
                                  Difference difference);

/// A round end of scale (1, 2 or 4 times a power of ten) that all but 1 % of the map's finite
/// values stay within; 1e-6 at least, so that a map of zeros has a scale too.
double difference_scale(std::span<const float> map);

/// Linear colour of t in 0..1 (magnitude) or -1..1 (sign), what is outside at the end's colour.
/// Lightness rises with t throughout, so a grey print keeps the order, and the sign too.
glm::vec3 difference_color(float t, Difference difference);

/// A picture (R, G, B, linear) on white with the bar of its colours under it, ticks at even steps
/// from end to end, two or more, and a caption, in the letters of study/label_font.h. At least as
/// wide as its text needs.
Image with_color_bar(const Image& picture, Difference palette, std::span<const std::string> ticks,
                     const std::string& caption);

struct FalseColor {
    Difference difference = Difference::magnitude;
    double scale = 1;          ///< the map's value at the end of the bar, > 0
    std::string caption = {};  ///< a line under the bar
};

/// The map in colours with its bar, ticks in percent, and the caption with the map's largest value.
/// NaN is green, which no map has. write_png with Display::Transform::srgb shows it as meant.
Image false_color(std::span<const float> map, int width, int height, const FalseColor& style);

}  // namespace fumarole::study
