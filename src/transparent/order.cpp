#include "transparent/order.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

namespace fumarole::transparent {

namespace {

/// What of a convex polygon lies where a function of places, linear in them, is 0 or more.
template <class Of>
std::vector<glm::dvec3> clipped(const std::vector<glm::dvec3>& corners, const Of& of)
{
    std::vector<glm::dvec3> left;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const glm::dvec3 &a = corners[i], &b = corners[(i + 1) % corners.size()];
        const double of_a = of(a), of_b = of(b);
        if (of_a >= 0)
            left.push_back(a);
        if ((of_a > 0 && of_b < 0) || (of_a < 0 && of_b > 0))
            left.push_back(a + (b - a) * (of_a / (of_a - of_b)));
    }
    return left;
}

/// How far the nearest and the farthest corner of one lie behind a plane [m].
glm::dvec2 behind(const Plane& plane, const Placed& one)
{
    glm::dvec2 range(std::numeric_limits<double>::infinity(),
                     -std::numeric_limits<double>::infinity());
    for (const glm::dvec3& at : one.corners) {
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

/// Works out where a flat one, or a piece of it, lies in the picture.
void see(Placed& one, const PreparedFrame& frame)
{
    const glm::dmat3 view_from_world = glm::transpose(frame.eye.world_from_view);
    const auto view_z = [&](const glm::dvec3& at) { return -(view_from_world * at).z; };
    const std::vector<glm::dvec3> seen =
        clipped(one.corners, [&](const glm::dvec3& at) { return view_z(at) - frame.eye.near; });
    one.outline.clear();
    for (const glm::dvec3& at : seen) {
        const glm::dvec4 clip = frame.host.clip_from_view * glm::dvec4(view_from_world * at, 1);
        one.outline.push_back((glm::dvec2(clip) / clip.w * 0.5 + 0.5) *
                              glm::dvec2(frame.picture_size));
    }
    if (one.seen.cuts.empty())
        return;
    constexpr double kFar = std::numeric_limits<double>::infinity();
    one.seen.view_z = {kFar, -kFar};
    for (const glm::dvec3& at : one.corners)
        one.seen.view_z = {std::min(one.seen.view_z.x, view_z(at)),
                           std::max(one.seen.view_z.y, view_z(at))};
    one.seen.area = {glm::dvec2(kFar), glm::dvec2(-kFar)};
    for (const glm::dvec2& at : one.outline)
        one.seen.area = {glm::min(one.seen.area.low, at), glm::max(one.seen.area.high, at)};
}

/// @returns nothing if it is flat and not seen: its edge is turned to the eye, or it has no area
std::optional<Placed> placed(const TransparentSet& transparents, const SeenTransparent& seen,
                             const PreparedFrame& frame)
{
    constexpr double kSlack = 1e-6;
    const glm::dmat4 box = transparents.world_from_box(seen);
    const Eye& eye = frame.eye;
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
    const glm::dvec3 &a = one.edges[0], &b = one.edges[1];
    one.corners = {one.corner, one.corner + a, one.corner + a + b, one.corner + b};
    if (one.is_flat) {
        see(one, frame);
        return one.planes.empty() ? std::nullopt : std::optional(one);
    }
    for (std::size_t i = 0; i < 4; ++i)
        one.corners.push_back(one.corners[i] + one.edges[2]);
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

/// Whether a side of one polygon has all of another beyond it. @param apart as far as that, or no
/// more than as far as that on this side
bool is_beside(const std::vector<glm::dvec2>& one, const std::vector<glm::dvec2>& other,
               double apart)
{
    for (std::size_t i = 0; i < one.size(); ++i) {
        const glm::dvec2 along = one[(i + 1) % one.size()] - one[i];
        const double length = glm::length(along);
        if (!(length > std::abs(apart)))
            continue;
        const glm::dvec2 across = glm::dvec2(-along.y, along.x) / length;
        const auto range = [&](const std::vector<glm::dvec2>& of) {
            glm::dvec2 all(std::numeric_limits<double>::infinity(),
                           -std::numeric_limits<double>::infinity());
            for (const glm::dvec2& at : of) {
                const double place = glm::dot(across, at - one[i]);
                all = {std::min(all.x, place), std::max(all.y, place)};
            }
            return all;
        };
        const glm::dvec2 own = range(one), its = range(other);
        if (its.x > own.y + apart || its.y < own.x - apart)
            return true;
    }
    return false;
}

/// Whether two flat ones are beside each other in the picture.
bool are_beside(const Placed& a, const Placed& b)
{
    // Pixels: rasterisers round a corner's place by less. Pieces often have a line in common, which
    // is where it is to far less than that.
    constexpr double kApart = 0.01, kCommon = -0.001;
    const bool are_whole = a.seen.cuts.empty() && b.seen.cuts.empty();
    const double apart = are_whole ? kApart : kCommon;
    return is_beside(a.outline, b.outline, apart) || is_beside(b.outline, a.outline, apart);
}

/// Which of two is in front where both are seen.
enum class Before { either, first, second, cross };

Before before(const Placed& a, const Placed& b)
{
    // Of two pieces of one a ray meets one.
    if (a.seen.index == b.seen.index || !areas_overlap(a.seen.area, b.seen.area))
        return Before::either;
    const double slack = std::max(a.slack, b.slack);
    if (a.seen.view_z.y + slack < b.seen.view_z.x)
        return Before::first;
    if (b.seen.view_z.y + slack < a.seen.view_z.x)
        return Before::second;
    if (a.is_flat && b.is_flat) {
        if (are_beside(a, b))
            return Before::either;
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

/// The line of the picture along which a plane meets another, as SeenTransparent::cuts has it.
glm::vec4 cut_line(const Plane& own, const Plane& other, const CameraRays& rays, const Eye& eye)
{
    // Through that line and along the rays, so that each ray is on one side of it.
    glm::dvec3 line;
    if (eye.perspective) {
        const glm::dvec3 normal = other.normal * own.distance - own.normal * other.distance;
        line = {glm::dot(normal, rays.direction_dx), glm::dot(normal, rays.direction_dy),
                glm::dot(normal, rays.direction)};
    } else {
        const double share =
            glm::dot(other.normal, rays.direction) / glm::dot(own.normal, rays.direction);
        const glm::dvec3 normal = other.normal - own.normal * share;
        line = {glm::dot(normal, rays.origin_dx), glm::dot(normal, rays.origin_dy),
                glm::dot(normal, rays.origin) - (other.distance - own.distance * share)};
    }
    const glm::dvec3 size = glm::abs(line);
    return {glm::vec3(line / std::max({size.x, size.y, size.z})), 0};
}

/// Cuts a flat one by a plane that goes through it, in the piece before it and that behind it.
std::array<Placed, 2> cut(const Placed& whole, const Plane& plane, const PreparedFrame& frame)
{
    constexpr double kBeside = 100;  // slacks: far more than what a pixel's place is rounded by
    std::array<Placed, 2> pieces{whole, whole};
    const glm::vec4 line = cut_line(whole.planes.front(), plane, frame.rays, frame.eye);
    for (std::size_t side = 0; side < 2; ++side) {
        Placed& piece = pieces.at(side);
        piece.corners = clipped(whole.corners, [&](const glm::dvec3& at) {
            return (side == 0 ? -1 : 1) * (glm::dot(plane.normal, at) - plane.distance);
        });
        // Where this cuts another's line off, that is none of its own.
        for (std::size_t i = piece.cut_by.size(); i-- > 0;) {
            const glm::dvec2 range = behind(piece.cut_by[i], piece);
            if (std::max(range.x, -range.y) > kBeside * piece.slack) {
                piece.cut_by.erase(piece.cut_by.begin() + static_cast<std::ptrdiff_t>(i));
                piece.seen.cuts.erase(piece.seen.cuts.begin() + static_cast<std::ptrdiff_t>(i));
            }
        }
        piece.cut_by.push_back(plane);
        piece.seen.cuts.emplace_back(glm::vec3(line), side == 0 ? 1 : 0);
        see(piece, frame);
    }
    return pieces;
}

/// What is put in order, in the course of it.
struct Ordering {
    std::vector<Placed> all;  ///< by their nearest view_z
    double slack = 0;
    int compared = 0;
    std::size_t pieces = 0;  ///< more than there had been
};

/// Puts the pieces of one, cut by a plane, in its place. @returns whether there may be so many
bool cut_at(Ordering& ordering, std::size_t at, const Plane& plane, const PreparedFrame& frame)
{
    constexpr std::size_t kMostPieces = 256;
    std::vector<Placed>& all = ordering.all;
    const auto place = [&](std::size_t i) { return all.begin() + static_cast<std::ptrdiff_t>(i); };
    const std::array<Placed, 2> pieces = cut(all[at], plane, frame);
    all.erase(place(at));
    for (const Placed& piece : pieces)
        all.insert(std::upper_bound(place(at), all.end(), piece,
                                    [](const Placed& a, const Placed& b) {
                                        return a.seen.view_z.x < b.seen.view_z.x;
                                    }),
                   piece);
    return ++ordering.pieces <= kMostPieces;
}

/// Which lie before which.
struct Relations {
    std::vector<std::vector<std::size_t>> behind;  ///< of each, those that it lies before
    std::vector<std::size_t> before;               ///< of each, how many lie before it
};

/// Compares each two, and cuts those that cross.
/// @returns what holds if none was cut; nothing if one can't be cut, or it takes long
std::optional<Relations> relate(Ordering& ordering, const PreparedFrame& frame)
{
    // Some milliseconds of them; more are told apart by depth alone, as sprites are.
    constexpr int kMostCompared = 1 << 16;
    std::vector<Placed>& all = ordering.all;
    Relations relations{std::vector<std::vector<std::size_t>>(all.size()),
                        std::vector<std::size_t>(all.size(), 0)};
    bool is_cut = false;
    for (std::size_t i = 0; i < all.size(); ++i)
        for (std::size_t k = i + 1; k < all.size();) {
            // Those that begin behind its farthest lie behind it, and so do all that come after.
            if (all[k].seen.view_z.x > all[i].seen.view_z.y + ordering.slack)
                break;
            if (++ordering.compared >= kMostCompared)
                return {};
            const Before which = before(all[i], all[k]);
            if (which == Before::cross) {
                // Of two the same is cut wherever they cross, so that there are fewer pieces.
                const std::size_t at = all[i].seen.index < all[k].seen.index ? k : i;
                if (!all[i].is_flat || !all[k].is_flat ||
                    !cut_at(ordering, at, all[i + k - at].planes.front(), frame))
                    return {};
                is_cut = true;
                if (at == i)  // a piece is in its place
                    k = i + 1;
                continue;
            }
            if (which != Before::either && !is_cut) {
                const std::size_t near = which == Before::first ? i : k;
                const std::size_t far = which == Before::first ? k : i;
                relations.behind[near].push_back(far);
                ++relations.before[far];
            }
            ++k;
        }
    return relations;
}

/// Those that have no ring before them: each time the first of those that none is left before.
std::vector<std::size_t> sorted(const Relations& relations)
{
    std::vector<std::size_t> left = relations.before, order;
    std::priority_queue<std::size_t, std::vector<std::size_t>, std::greater<>> free;
    for (std::size_t i = 0; i < left.size(); ++i)
        if (left[i] == 0)
            free.push(i);
    while (!free.empty()) {
        order.push_back(free.top());
        free.pop();
        for (const std::size_t far : relations.behind[order.back()])
            if (--left[far] == 0)
                free.push(far);
    }
    return order;
}

/// Cuts one of a ring. @param order the rest @returns whether there is one that can be
bool cut_ring(Ordering& ordering, const Relations& relations, const std::vector<std::size_t>& order,
              const PreparedFrame& frame)
{
    const std::vector<Placed>& all = ordering.all;
    std::vector<bool> is_left(all.size(), true);
    for (const std::size_t i : order)
        is_left[i] = false;
    const auto goes_through = [&](std::size_t by, std::size_t at) {
        const glm::dvec2 range = behind(all[by].planes.front(), all[at]);
        return range.x < -ordering.slack && range.y > ordering.slack;
    };
    for (std::size_t i = 0; i < all.size(); ++i)
        for (const std::size_t k : relations.behind[i]) {
            if (!is_left[i] || !is_left[k] || !all[i].is_flat || !all[k].is_flat)
                continue;
            for (const auto& [by, at] : {std::pair{i, k}, std::pair{k, i}})
                if (goes_through(by, at))
                    return cut_at(ordering, at, all[by].planes.front(), frame);
        }
    return false;
}

}  // namespace

std::vector<Placed> place(const TransparentSet& transparents, const SeenTransparents& seen,
                          const PreparedFrame& frame)
{
    std::vector<Placed> all;
    for (const SeenTransparent& one : seen.list)
        if (const std::optional<Placed> there = placed(transparents, one, frame))
            all.push_back(*there);
    return all;
}

std::optional<std::vector<Placed>> put_in_order(std::vector<Placed> placed,
                                                const PreparedFrame& frame)
{
    Ordering ordering{std::move(placed)};
    for (const Placed& one : ordering.all)
        ordering.slack = std::max(ordering.slack, one.slack);
    for (;;) {
        const std::size_t pieces = ordering.pieces;
        const std::optional<Relations> relations = relate(ordering, frame);
        if (!relations)
            return {};
        if (ordering.pieces > pieces)
            continue;
        const std::vector<std::size_t> order = sorted(*relations);
        if (order.size() < ordering.all.size()) {
            if (!cut_ring(ordering, *relations, order, frame))
                return {};
            continue;
        }
        std::vector<Placed> ordered;
        for (const std::size_t i : order) {
            if (ordering.all[i].seen.cuts.size() > MAX_CUTS)
                return {};
            ordered.push_back(ordering.all[i]);
        }
        return ordered;
    }
}

bool has_pieces(const std::vector<Placed>& ordered)
{
    return std::any_of(ordered.begin(), ordered.end(),
                       [](const Placed& one) { return !one.seen.cuts.empty(); });
}

}  // namespace fumarole::transparent
