#include "transparent/order.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fumarole::transparent {

namespace {

/// How far the nearest and the farthest corner of one lie behind a plane [m].
glm::dvec2 behind(const Plane& plane, const Placed& one)
{
    glm::dvec2 range(std::numeric_limits<double>::infinity(),
                     -std::numeric_limits<double>::infinity());
    for (int i = 0; i < (one.is_flat ? 4 : 8); ++i) {
        const glm::dvec3 at = one.corner + double(i % 2) * one.edges[0] +
                              double(i / 2 % 2) * one.edges[1] + double(i / 4) * one.edges[2];
        const double behind = glm::dot(plane.normal, at) - plane.distance;
        range = {std::min(range.x, behind), std::max(range.y, behind)};
    }
    return range;
}

/// The plane through a place along two edges.
/// @returns nothing if they span none, or it has its edge turned to the eye
std::optional<Plane> plane_of(const glm::dvec3& at, const glm::dvec3& a, const glm::dvec3& b,
                              const Eye& eye)
{
    constexpr double kEdgeOn = 1e-12;
    const glm::dvec3 across = glm::cross(a, b);
    const double area = glm::length(across), size = std::max(glm::length(a), glm::length(b));
    if (!(area > kEdgeOn * size * size))
        return {};
    Plane plane{across / area, glm::dot(across / area, at)};
    const double away = eye.perspective ? plane.distance : glm::dot(plane.normal, eye.forward);
    if (std::abs(away) <= kEdgeOn * (eye.perspective ? size : 1.0))
        return {};
    if (away < 0)
        plane = {-plane.normal, -plane.distance};
    return plane;
}

/// @returns nothing if it is flat and not seen: its edge is turned to the eye, or it has no area
std::optional<Placed> placed(const TransparentSet& transparents, const SeenTransparent& seen,
                             const Eye& eye)
{
    constexpr double kSlack = 1e-6;
    const glm::dmat4 box = transparents.world_from_box(seen);
    Placed one;
    one.seen = seen;
    one.is_flat = transparents.is_flat(seen);
    one.corner = glm::dvec3(box[3]) - eye.position;
    for (int i = 0; i < 3; ++i) {
        one.edges.at(static_cast<std::size_t>(i)) = glm::dvec3(box[i]);
        one.slack = std::max(one.slack, kSlack * glm::length(glm::dvec3(box[i])));
    }
    const auto add = [&](const glm::dvec3& at, std::size_t a, std::size_t b) {
        if (const auto plane = plane_of(at, one.edges.at(a), one.edges.at(b), eye))
            one.planes.push_back(*plane);
    };
    add(one.corner, 0, 1);
    if (one.is_flat)
        return one.planes.empty() ? std::nullopt : std::optional(one);
    add(one.corner, 1, 2);
    add(one.corner, 2, 0);
    const glm::dvec3 far = one.corner + one.edges[0] + one.edges[1] + one.edges[2];
    add(far, 0, 1);
    add(far, 1, 2);
    add(far, 2, 0);
    return one;
}

bool areas_overlap(const DepthsAsked::Area& a, const DepthsAsked::Area& b)
{
    return glm::all(glm::lessThanEqual(a.low, b.high)) &&
           glm::all(glm::lessThanEqual(b.low, a.high));
}

/// Which of two is in front where both are seen.
enum class Before { either, first, second, cross };

Before before(const Placed& a, const Placed& b)
{
    if (!areas_overlap(a.seen.area, b.seen.area))
        return Before::either;
    const double slack = std::max(a.slack, b.slack);
    if (a.seen.view_z.y + slack < b.seen.view_z.x)
        return Before::first;
    if (b.seen.view_z.y + slack < a.seen.view_z.x)
        return Before::second;
    if (a.is_flat && b.is_flat) {
        const glm::dvec2 range = behind(b.planes.front(), a);
        if (range.x >= -slack && range.y <= slack)  // in one plane
            return a.seen.index > b.seen.index ? Before::first : Before::second;
    }
    bool first = false, second = false;
    for (const Placed* const of : {&a, &b})
        for (const Plane& plane : of->planes) {
            const glm::dvec2 of_a = behind(plane, a), of_b = behind(plane, b);
            first = first || (of_a.y <= slack && of_b.x >= -slack);
            second = second || (of_b.y <= slack && of_a.x >= -slack);
        }
    if (first && second)
        return Before::either;
    return first ? Before::first : second ? Before::second : Before::cross;
}

}  // namespace

std::vector<Placed> place(const TransparentSet& transparents, const SeenTransparents& seen,
                          const Eye& eye)
{
    std::vector<Placed> all;
    for (const SeenTransparent& one : seen.list)
        if (const std::optional<Placed> there = placed(transparents, one, eye))
            all.push_back(*there);
    return all;
}

std::optional<std::vector<Placed>> put_in_order(const std::vector<Placed>& placed)
{
    // Some milliseconds of them; more are told apart by depth alone, as sprites are.
    constexpr int kMostCompared = 1 << 16;
    int compared = 0;
    double slack = 0;
    for (const Placed& one : placed)
        slack = std::max(slack, one.slack);
    // They come by their nearest depth: those that begin behind its farthest lie behind it.
    const auto is_nearest = [&](std::size_t at, std::size_t first, const std::vector<bool>& taken) {
        for (std::size_t i = first; i < placed.size(); ++i) {
            if (i == at || taken[i])
                continue;
            if (placed[i].seen.view_z.x > placed[at].seen.view_z.y + slack)
                return true;
            ++compared;
            const Before which = before(placed[at], placed[i]);
            if (which == Before::second || which == Before::cross)
                return false;
        }
        return true;
    };
    std::vector<Placed> ordered;
    std::vector<bool> taken(placed.size(), false);
    for (std::size_t first = 0; ordered.size() < placed.size();) {
        std::size_t at = first;
        while (at < placed.size() && (taken[at] || !is_nearest(at, first, taken)) &&
               compared < kMostCompared)
            ++at;
        if (at == placed.size() || compared >= kMostCompared)
            return {};
        ordered.push_back(placed[at]);
        taken[at] = true;
        while (first < placed.size() && taken[first])
            ++first;
    }
    return ordered;
}

}  // namespace fumarole::transparent
