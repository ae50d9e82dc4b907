#include "transparent/panes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace fumarole::transparent {

namespace {

/// A pane in a frame: positions are metres from the eye.
struct Placed {
    PlainPane pane;
    DepthsAsked::Area area;
    std::size_t index = 0;
    glm::dvec3 normal{0};  ///< away from the eye, unit length
    double distance = 0;   ///< distance of its plane from the eye [m]
    double slack = 0;      ///< below which a distance from its plane is none [m]

    [[nodiscard]] std::array<glm::dvec3, 4> corners() const
    {
        const glm::dvec3& p = pane.corner;
        return {p, p + pane.edges[0], p + pane.edges[1], p + pane.edges[0] + pane.edges[1]};
    }
    /// How far the nearest and the farthest corner of another lie behind its plane [m].
    [[nodiscard]] glm::dvec2 behind(const Placed& other) const
    {
        glm::dvec2 range(std::numeric_limits<double>::infinity(),
                         -std::numeric_limits<double>::infinity());
        for (const glm::dvec3& p : other.corners()) {
            const double behind = glm::dot(normal, p) - distance;
            range = {std::min(range.x, behind), std::max(range.y, behind)};
        }
        return range;
    }
};

/// @returns nothing if its edge is turned to the eye, or it has no area: then it is not seen
std::optional<Placed> placed(PlainPane pane, const SeenTransparent& seen, const Eye& eye)
{
    constexpr double kEdgeOn = 1e-12, kSlack = 1e-6;
    pane.corner -= eye.position;
    Placed one{pane, seen.area, seen.index};
    const glm::dvec3 across = glm::cross(pane.edges[0], pane.edges[1]);
    const double area = glm::length(across);
    const double size = std::max(glm::length(pane.edges[0]), glm::length(pane.edges[1]));
    if (!(area > kEdgeOn * size * size))
        return {};
    one.normal = across / area;
    one.slack = kSlack * size;
    one.distance = glm::dot(one.normal, pane.corner);
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
    if (!areas_overlap(a.area, b.area))
        return Before::either;
    const glm::dvec2 a_of_b = b.behind(a), b_of_a = a.behind(b);
    const double slack = std::max(a.slack, b.slack);
    if (a_of_b.x >= -slack && a_of_b.y <= slack)  // in one plane
        return a.index > b.index ? Before::first : Before::second;
    const bool first = a_of_b.y <= slack || b_of_a.x >= -slack;
    const bool second = b_of_a.y <= slack || a_of_b.x >= -slack;
    if (first && second)
        return Before::either;
    return first ? Before::first : second ? Before::second : Before::cross;
}

/// Puts them in order, the nearest first. @returns false if they have none
bool sort_panes(std::vector<Placed>& panes)
{
    std::vector<Placed> left = std::move(panes);
    panes.clear();
    while (!left.empty()) {
        const auto is_nearest = [&](const Placed& one) {
            return std::all_of(left.begin(), left.end(), [&](const Placed& other) {
                if (&one == &other)
                    return true;
                const Before which = before(one, other);
                return which == Before::either || which == Before::first;
            });
        };
        const auto nearest = std::find_if(left.begin(), left.end(), is_nearest);
        if (nearest == left.end())
            return false;
        panes.push_back(*nearest);
        left.erase(nearest);
    }
    return true;
}

/// Where rays meet its plane, as shared::PaneParams has it, at a place of the picture in NDC.
glm::dvec4 met(const Placed& one, const CameraRays& rays, glm::dvec2 ndc)
{
    const glm::dvec3 origin = rays.origin + ndc.x * rays.origin_dx + ndc.y * rays.origin_dy;
    const glm::dvec3 direction =
        rays.direction + ndc.x * rays.direction_dx + ndc.y * rays.direction_dy;
    const auto& [a, b] = one.pane.edges;
    const glm::dvec3 to_a = glm::cross(b, one.normal), to_b = glm::cross(one.normal, a);
    const glm::dvec3 along_a = to_a / glm::dot(a, to_a), along_b = to_b / glm::dot(b, to_b);
    const glm::dvec3 from_corner = origin - one.pane.corner;
    const double w = glm::dot(one.normal, direction);
    const double z = -glm::dot(one.normal, from_corner);
    const auto along = [&](const glm::dvec3& axis) {
        return glm::dot(axis, from_corner) * w + glm::dot(axis, direction) * z;
    };
    return {along(along_a), along(along_b), z, w};
}

}  // namespace

std::optional<shared::PaneParams> panes_in_order(const TransparentSet& transparents,
                                                 const SeenTransparents& seen,
                                                 const PreparedFrame& frame)
{
    if (frame.settings.transparency != FrameSettings::Transparency::split ||
        seen.list.size() > MAX_PANES)
        return {};
    std::vector<Placed> panes;
    for (const SeenTransparent& one : seen.list) {
        const std::optional<PlainPane> pane = transparents.plain(one);
        if (!pane)
            return {};
        if (const std::optional<Placed> there = placed(*pane, one, frame.eye))
            panes.push_back(*there);
    }
    if (!sort_panes(panes))
        return {};
    shared::PaneParams params{};
    params.view_z = glm::vec2(frame.eye.near, frame.eye.far);
    params.count = static_cast<int>(panes.size());
    for (std::size_t i = 0; i < panes.size(); ++i) {
        const auto at = [&](double x, double y) { return met(panes[i], frame.rays, {x, y}); };
        const glm::dvec4 middle = at(0, 0);
        params.at[i] = glm::vec4(middle);
        params.at_dx[i] = glm::vec4(at(1, 0) - middle);
        params.at_dy[i] = glm::vec4(at(0, 1) - middle);
        const glm::vec4& source = panes[i].pane.source;
        const glm::vec3 limited = glm::min(glm::vec3(source), frame.params.radiance_limit);
        params.emitted[i] = glm::vec4(limited * panes[i].pane.of_source(limited), 0);
        params.kept[i] = glm::vec4(panes[i].pane.of_behind(limited), 0);
    }
    return params;
}

void PaneLayer::resize(const gl::Device& device, glm::ivec2 size)
{
    if (added && glm::ivec2(added.size()) == size)
        return;
    // Sums of powers of two are exact in 32 bits.
    added = gl::Texture::make_2d(device, "what panes add", size, GL_RGBA32F, gl::Filter::linear);
    framebuffer = {device, "what panes add"};
    framebuffer.attach_color({added.view()});
}

}  // namespace fumarole::transparent
