#pragma once

#include <algorithm>
#include <limits>

#include <fumarole/bounds.h>

namespace fumarole {

/// Where origin + t direction is inside a box: from x to y, none if x >= y. Kay and Kajiya 1986.
inline glm::dvec2 ray_range(glm::dvec3 origin, glm::dvec3 direction, const Bounds& box)
{
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    glm::dvec2 range(-kInfinity, kInfinity);
    for (int axis = 0; axis < 3; ++axis) {
        const double o = origin[axis], d = direction[axis];
        if (d == 0) {
            if (!(o > box.min[axis] && o < box.max[axis]))
                return {kInfinity, -kInfinity};
            continue;
        }
        const double a = (box.min[axis] - o) / d, b = (box.max[axis] - o) / d;
        range = {std::max(range.x, std::min(a, b)), std::min(range.y, std::max(a, b))};
    }
    return range;
}

}  // namespace fumarole
