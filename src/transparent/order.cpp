#include "transparent/order.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fumarole::transparent {

namespace {

/// How far the nearest and the farthest corner of another lie behind its plane [m].
glm::dvec2 behind(const Placed& one, const Placed& other)
{
    glm::dvec2 range(std::numeric_limits<double>::infinity(),
                     -std::numeric_limits<double>::infinity());
    for (int i = 0; i < 4; ++i) {
        const glm::dvec3 at =
            other.corner + double(i % 2) * other.edges[0] + double(i / 2) * other.edges[1];
        const double behind = glm::dot(one.normal, at) - one.distance;
        range = {std::min(range.x, behind), std::max(range.y, behind)};
    }
    return range;
}

/// @returns nothing if its edge is turned to the eye, or it has no area: then it is not seen
std::optional<Placed> placed(const SeenTransparent& seen, const Eye& eye)
{
    constexpr double kEdgeOn = 1e-12, kSlack = 1e-6;
    const glm::dmat4& object = seen.world_from_object;
    Placed one{
        seen, glm::dvec3(object[3]) - eye.position, {glm::dvec3(object[0]), glm::dvec3(object[1])}};
    const glm::dvec3 across = glm::cross(one.edges[0], one.edges[1]);
    const double area = glm::length(across);
    const double size = std::max(glm::length(one.edges[0]), glm::length(one.edges[1]));
    if (!(area > kEdgeOn * size * size))
        return {};
    one.normal = across / area;
    one.slack = kSlack * size;
    one.distance = glm::dot(one.normal, one.corner);
    const double away = eye.perspective ? one.distance : glm::dot(one.normal, eye.forward);
    if (std::abs(away) <= kEdgeOn * (eye.perspective ? size : 1.0))
        return {};
    if (away < 0) {
        one.normal = -one.normal;
        one.distance = -one.distance;
    }
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
    const glm::dvec2 a_of_b = behind(b, a), b_of_a = behind(a, b);
    const double slack = std::max(a.slack, b.slack);
    if (a_of_b.x >= -slack && a_of_b.y <= slack)  // in one plane
        return a.seen.index > b.seen.index ? Before::first : Before::second;
    const bool first = a_of_b.y <= slack || b_of_a.x >= -slack;
    const bool second = b_of_a.y <= slack || a_of_b.x >= -slack;
    if (first && second)
        return Before::either;
    return first ? Before::first : second ? Before::second : Before::cross;
}

}  // namespace

std::vector<Placed> place(const SeenTransparents& seen, const Eye& eye)
{
    std::vector<Placed> all;
    for (const SeenTransparent& one : seen.list)
        if (const std::optional<Placed> there = placed(one, eye))
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
