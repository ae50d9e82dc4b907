#include "light/lattice_ways.h"

#include <array>
#include <cassert>
#include <cstdlib>
#include <numbers>

namespace fumarole::light {

namespace {

/// Ways that are one another's mirror images.
struct Kind {
    glm::ivec3 sizes{0};          ///< sizes of a step along the axes, the largest first
    double of_26 = 0, of_74 = 0;  ///< parts of the sphere that each of them stands for
};

// With the degrees 0, 4 and 6, or 0, 4, 6, 8 and 10, that a cube's symmetry leaves, one equation
// each.
constexpr std::array kKinds{Kind{{1, 0, 0}, 1.0 / 21, 19.0 / 990},
                            Kind{{1, 1, 0}, 4.0 / 105, 52.0 / 4455},
                            Kind{{1, 1, 1}, 9.0 / 280, 27.0 / 3080},
                            Kind{{2, 1, 0}, 0, 3125.0 / 249480}, Kind{{2, 1, 1}, 0, 6.0 / 385}};

glm::ivec3 sorted(glm::ivec3 step)
{
    glm::ivec3 s{std::abs(step.x), std::abs(step.y), std::abs(step.z)};
    if (s.x < s.y)
        std::swap(s.x, s.y);
    if (s.y < s.z)
        std::swap(s.y, s.z);
    if (s.x < s.y)
        std::swap(s.x, s.y);
    return s;
}

}  // namespace

std::vector<LatticeWay> lattice_ways(int count)
{
    assert(count == kNearWays || count == kAllWays);
    std::vector<LatticeWay> ways;
    for (const Kind& kind : kKinds) {
        const double part = count == kNearWays ? kind.of_26 : kind.of_74;
        if (part == 0)
            continue;
        for (int i = 0; i < 125 / 2; ++i)  // the rest are their opposites
            if (const glm::ivec3 step = glm::ivec3(i % 5, i / 5 % 5, i / 25) - 2;
                sorted(step) == kind.sizes)
                for (const glm::ivec3 way : {step, -step})
                    ways.push_back({way, 4 * std::numbers::pi * part});
    }
    return ways;
}

}  // namespace fumarole::light
