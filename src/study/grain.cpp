#include "study/grain.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace fumarole::study {

namespace {

/// Reorders `values`.
double median(std::vector<double>& values)
{
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

}  // namespace

double grain(std::span<const float> first, std::span<const float> second, int width,
             const InSteps& in_steps)
{
    constexpr std::size_t kSquare = 8;           // pixels
    constexpr double kExceeded = 0.01;           // of the squares
    constexpr double kDeviations = 1 / 0.67449;  // of a normal distribution, by the median of |x|
    const auto columns = static_cast<std::size_t>(width);
    const std::size_t rows = first.size() / 3 / columns;
    std::vector<double> squares, moved;
    for (std::size_t top = 0; top < rows; top += kSquare)
        for (std::size_t left = 0; left < columns; left += kSquare) {
            moved.clear();
            for (std::size_t y = top; y < std::min(top + kSquare, rows); ++y)
                for (std::size_t x = left; x < std::min(left + kSquare, columns); ++x) {
                    const std::size_t at = 3 * (y * columns + x);
                    const glm::vec3 half =
                        0.5f * (in_steps({second[at], second[at + 1], second[at + 2]}) -
                                in_steps({first[at], first[at + 1], first[at + 2]}));
                    moved.push_back(std::sqrt(glm::dot(half, half) / 3));
                }
            squares.push_back(kDeviations * median(moved));
        }
    if (squares.empty())
        return 0;
    const auto above = static_cast<std::ptrdiff_t>(kExceeded * static_cast<double>(squares.size()));
    const auto found = squares.end() - 1 - above;
    std::nth_element(squares.begin(), found, squares.end());
    return *found;
}

InSteps relative_steps(std::span<const float> picture)
{
    constexpr double kStep = 0.01, kDark = 0.1;  // of the value; of the mean square, as relMSE
    double square = 0;
    for (const float value : picture)
        square += static_cast<double>(value) * static_cast<double>(value);
    const double dark = std::sqrt(kDark * square / static_cast<double>(picture.size()));
    // As many steps up to a value as its logarithm has grown by since `dark`: asinh is linear below
    // and a logarithm above, with the slope 1 / sqrt(value^2 + dark^2).
    return [dark](glm::vec3 rgb) {
        if (!(dark > 0))
            return glm::vec3(0);
        return glm::vec3(glm::asinh(glm::dvec3(rgb) / dark) / kStep);
    };
}

}  // namespace fumarole::study
