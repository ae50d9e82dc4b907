#include "light/flames.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "light/surface_rays.h"

namespace fumarole::light {

namespace {

using medium::Glow;

/// A lattice tells the form of what is longer than so many nodes, and of longer ones as well as a
/// few lights do; of a light's way far from it it knows less.
constexpr double kFewNodes = 2.5, kMostNodes = 8;
/// Optical depths from the middle of a ball to its rim: where its light comes from all of it, and
/// where most comes from its rim.
constexpr double kThin = 0.5, kThick = 4;
/// Parts of a ball's radius that surfaces stand off its middle: a log in a fire would hide all of
/// it, and one in its rim is lit by less of it than a light in its middle.
constexpr double kHidden = 0.1, kBeside = 0.75;
/// And so many off that they tell nothing of its form.
constexpr double kFar = 3;

/// Places of equal parts, whose spread and that of a ball around each are the flame's.
struct Parts {
    std::vector<glm::dvec3> at;
    double ball = 0;  ///< metres: their radius
};

/// @param near surfaces stand so near that they tell its parts
Parts parts_of(const Glow& glow, bool near)
{
    constexpr double kLonger = 1.3;  // than it is thick, so that it is told from a ball
    constexpr double kOfPart = 0.5;  // of the thickness
    constexpr int kMost = 3;         // along an axis
    const Glow::Axes axes = glow.axes();
    const double thickness = axes.edges.z * (near ? kOfPart : 1);
    glm::ivec3 counts(1);
    for (int axis = 0; axis < 3; ++axis)
        if (const double longer = axes.edges[axis] / thickness; longer > kLonger)
            counts[axis] = near ? 2 : std::clamp(static_cast<int>(0.8 * longer + 0.5), 2, kMost);
    if (counts.x * counts.y > 4 && !near)
        counts.x = counts.y = 2;
    Parts parts{{glow.middle}, 0};
    double spread = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double edge = axes.edges[axis];
        if (counts[axis] == 1) {
            spread += edge * edge;
            continue;
        }
        // So many places in a row, as far apart as this, have a twelfth of (n^2 - 1) times its
        // square for a spread.
        const int n = counts[axis];
        const double apart =
            std::sqrt((edge * edge - thickness * thickness) / static_cast<double>(n * n - 1));
        std::vector<glm::dvec3> all;
        for (const glm::dvec3& at : parts.at)
            for (int i = 0; i < n; ++i)
                all.push_back(at + axes.directions[axis] * (apart * (i - 0.5 * (n - 1))));
        parts.at = std::move(all);
        spread += thickness * thickness;
    }
    // Of a ball of radius 1 the spread along an axis is 1/5, of a box of edges 1 1/12.
    parts.ball = std::sqrt(spread / 3 * 5 / 12);
    return parts;
}

}  // namespace

double FlameScale::longest() const
{
    return scatters ? kMostNodes * node : node > 0 ? std::numeric_limits<double>::max() : 0;
}

Flames lights_of_flames(const std::vector<std::optional<medium::SmallGlow>>& glows,
                        const FlameScale& scale, const std::vector<Surface>& surfaces,
                        std::size_t room)
{
    /// A disc whose light falls off beside it as a ball's of radius 1, where a line sees them.
    constexpr double kDiscOfBall = 0.87;
    std::vector<std::size_t> order(glows.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::erase_if(order, [&](std::size_t i) { return !glows[i]; });
    const auto power = [&](std::size_t i) {
        const glm::dvec3 all = glows[i]->glow.power;
        return all.r + all.g + all.b;
    };
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return power(a) > power(b); });
    Flames flames;
    flames.split_off.assign(glows.size(), false);
    if (order.empty())
        return flames;
    const SurfaceRays rays(surfaces);
    for (const std::size_t i : order) {
        const Glow& glow = glows[i]->glow;
        const auto is_near = [&](const Parts& parts, double radii) {
            return std::any_of(parts.at.begin(), parts.at.end(),
                               [&](glm::dvec3 at) { return rays.is_near(at, radii * parts.ball); });
        };
        Parts parts = parts_of(glow, false);
        if (!scale.scatters && is_near(parts, kFar))
            parts = parts_of(glow, true);
        const double tau = std::max({glow.sigma_t.r, glow.sigma_t.g, glow.sigma_t.b}) * parts.ball;
        const bool small = glow.axes().edges.x <= kFewNodes * scale.node;
        if (tau > (small ? kThick : kThin) || parts.at.size() > room)
            continue;
        if (is_near(parts, small ? kHidden : kBeside))
            continue;
        room -= parts.at.size();
        flames.split_off[i] = true;
        // Its own smoke is more in a light's way than in that of what glows at a flame's rim.
        const glm::dvec3 part =
            glow.power * glows[i]->cells.escapes(parts.at) / static_cast<double>(parts.at.size());
        for (const glm::dvec3& at : parts.at)
            flames.lights.push_back({{at, glm::vec3(part)}, kDiscOfBall * parts.ball});
    }
    return flames;
}

}  // namespace fumarole::light
