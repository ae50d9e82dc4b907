#pragma once

#include <functional>
#include <glm/glm.hpp>
#include <span>

namespace fumarole::study {

/// A colour in the steps in which a format of pictures tells values apart; what is a step apart is
/// just told apart.
using InSteps = std::function<glm::vec3(glm::vec3)>;

/// How far the mean of some frames is from what more of them would come to, in steps: by how much
/// their second half moved the mean of the first, whose standard deviation is the mean's own where
/// frames are independent, and more where each fills gaps that those before it left.
///
/// In squares of 8 x 8 pixels (less at the edges): the standard deviation as the median of what is
/// moved tells it, so that edges of surfaces, which are no grain, don't count. Of all squares, the
/// one that 1 % of them exceed, or the largest where there are less than a hundred.
/// @param first, second RGB of the means of both halves, rows of `width` pixels
double grain(std::span<const float> first, std::span<const float> second, int width,
             const InSteps& in_steps);

/// Of linear floats, which may be shown at any exposure: 1 % of a colour, or, where it is dark, of
/// what relative MSE counts (study/metrics.h). A step of 8 bits is as much, on a screen near white.
InSteps relative_steps(std::span<const float> picture);

}  // namespace fumarole::study
