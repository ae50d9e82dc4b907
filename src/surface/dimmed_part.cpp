#include "surface/dimmed_part.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ray_range.h"

namespace fumarole::surface {

namespace {

constexpr int kBandRows = 64;  ///< along an edge of what llvmpipe rasterises at once

/// Metres after which all that comes from a box along `way` has left another, or more.
double reach(const Bounds& from, const Bounds& other, glm::dvec3 way)
{
    // A point leaves by the first of three faces, and the last of the box's by each is a corner.
    double least = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
        if (way[axis] > 0)
            least = std::min(least, (other.max[axis] - from.min[axis]) / way[axis]);
        if (way[axis] < 0)
            least = std::min(least, (other.min[axis] - from.max[axis]) / way[axis]);
    }
    return std::max(least, 0.0);
}

using Polygon = std::vector<glm::dvec3>;

/// The part of a convex polygon where distance() is at most 0. Sutherland and Hodgman
/// 1974, "Reentrant Polygon Clipping".
template <typename Distance> Polygon clipped(const Polygon& polygon, const Distance& distance)
{
    Polygon inside;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const glm::dvec3 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
        const double from = distance(a), to = distance(b);
        if (from <= 0)
            inside.push_back(a);
        if ((from <= 0) != (to <= 0))
            inside.push_back(glm::mix(a, b, from / (from - to)));
    }
    return inside;
}

/// Faces of a box that is moved by up to `way`, and some more within it.
std::vector<Polygon> swept_faces(const Bounds& box, glm::dvec3 way)
{
    std::vector<Polygon> faces;
    for (int axis = 0; axis < 3; ++axis) {
        const int u = 1 << axis, v = 1 << (axis + 1) % 3, w = 1 << (axis + 2) % 3;
        for (const int side : {0, u}) {
            const Polygon face{box.corner(side), box.corner(side | v), box.corner(side | v | w),
                               box.corner(side | w)};
            Polygon moved;
            for (const glm::dvec3& corner : face)
                moved.push_back(corner + way);
            faces.push_back(face);
            faces.push_back(moved);
        }
        for (const int edge : {0, v, w, v | w}) {
            const glm::dvec3 a = box.corner(edge), b = box.corner(edge | u);
            faces.push_back({a, b, b + way, a + way});
        }
    }
    return faces;
}

/// Points whose convex hull is the part in `other` of a box that is moved by up to `way`.
std::vector<glm::dvec3> corners_within(const Bounds& box, glm::dvec3 way, const Bounds& other)
{
    std::vector<glm::dvec3> corners;
    for (Polygon face : swept_faces(box, way)) {
        for (int axis = 0; axis < 3; ++axis) {
            face = clipped(face, [&](const glm::dvec3& p) { return other.min[axis] - p[axis]; });
            face = clipped(face, [&](const glm::dvec3& p) { return p[axis] - other.max[axis]; });
        }
        corners.insert(corners.end(), face.begin(), face.end());
    }
    for (int i = 0; i < 8; ++i) {
        const glm::dvec2 inside = ray_range(other.corner(i), -way, box);
        if (std::max(inside.x, 0.0) <= std::min(inside.y, 1.0))
            corners.push_back(other.corner(i));
    }
    return corners;
}

/// The corners of their convex hull, or some more. Andrew 1979, "Another Efficient
/// Algorithm for Convex Hulls in Two Dimensions".
std::vector<glm::dvec2> hull_of(std::vector<glm::dvec2> points)
{
    std::sort(points.begin(), points.end(), [](const glm::dvec2& a, const glm::dvec2& b) {
        return a.x < b.x || (a.x == b.x && a.y < b.y);
    });
    std::vector<glm::dvec2> hull;
    for (const double turn : {1.0, -1.0}) {
        const std::size_t first = hull.size();
        for (const glm::dvec2& p : points) {
            const auto is_inside = [&] {
                const glm::dvec2 a = hull[hull.size() - 2], b = hull.back();
                return turn * ((b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x)) <= 0;
            };
            while (hull.size() >= first + 2 && is_inside())
                hull.pop_back();
            hull.push_back(p);
        }
    }
    return hull;
}

/// Pixels, of points of which none is at the eye or behind it; else none.
std::optional<std::vector<glm::dvec2>> to_pixels(const PreparedFrame& frame,
                                                 std::span<const glm::dvec3> points)
{
    const glm::dmat4 clip_from_world = frame.host.clip_from_view * frame.host.view_from_world;
    std::vector<glm::dvec2> pixels;
    for (const glm::dvec3& point : points) {
        const glm::dvec4 clip = clip_from_world * glm::dvec4(point, 1.0);
        if (frame.eye.perspective && !(clip.w > frame.eye.near))
            return {};
        pixels.push_back((glm::dvec2(clip) / clip.w * 0.5 + 0.5) * glm::dvec2(frame.picture_size));
    }
    return pixels;
}

/// The least and the largest x of what of their convex hull lies in rows; x > y: nothing does.
glm::dvec2 extent_in(const std::vector<glm::dvec2>& points, glm::dvec2 rows)
{
    glm::dvec2 extent(std::numeric_limits<double>::infinity(),
                      -std::numeric_limits<double>::infinity());
    for (const glm::dvec2& p : points)
        for (const glm::dvec2& q : points) {
            if (p.y > q.y || p.y > rows.y || q.y < rows.x)
                continue;
            for (const double y : {std::max(p.y, rows.x), std::min(q.y, rows.y)}) {
                const double t = q.y > p.y ? (y - p.y) / (q.y - p.y) : 0;
                const double x = glm::mix(p.x, q.x, t);
                extent = {std::min(extent.x, x), std::max(extent.y, x)};
            }
        }
    return extent;
}

/// What of the picture one of the hulls may reach.
std::vector<PictureBand> bands_of(std::span<const std::vector<glm::dvec2>> hulls, glm::ivec2 size)
{
    constexpr double kMargin = 2;  // pixels: of what a float makes of a corner
    std::vector<PictureBand> bands;
    for (int row = 0; row < size.y; row += kBandRows) {
        const int end = std::min(row + kBandRows, size.y);
        glm::dvec2 extent(size.x, 0);
        for (const std::vector<glm::dvec2>& hull : hulls) {
            const glm::dvec2 own = extent_in(hull, {row - kMargin, end + kMargin});
            extent = {std::min(extent.x, own.x - kMargin), std::max(extent.y, own.y + kMargin)};
        }
        // Of a corner just before the eye it is too far aside for an integer.
        const double width = size.x;
        const int low = static_cast<int>(std::floor(std::clamp(extent.x, 0.0, width)));
        const int high = static_cast<int>(std::ceil(std::clamp(extent.y, 0.0, width)));
        if (low < high)
            bands.push_back({{low, row}, {high - low, end - row}});
    }
    return bands;
}

}  // namespace

std::optional<std::vector<PictureBand>> dimmed_part(const PreparedFrame& frame, const Bounds& media,
                                                    const Bounds& surface,
                                                    std::span<const glm::dvec3> to_suns)
{
    std::vector<std::vector<glm::dvec2>> hulls;
    for (const glm::dvec3& to_sun : to_suns) {
        const double metres = reach(media, surface, -to_sun);
        if (!std::isfinite(metres) || media.empty())
            return {};
        auto pixels = to_pixels(frame, corners_within(media, -to_sun * metres, surface));
        if (!pixels)
            return {};
        hulls.push_back(hull_of(std::move(*pixels)));
    }
    return bands_of(hulls, frame.picture_size);
}

std::optional<std::vector<PictureBand>> part_within(const PreparedFrame& frame, const Bounds& box,
                                                    const Bounds& surface)
{
    auto pixels = to_pixels(frame, corners_within(box, glm::dvec3(0), surface));
    if (!pixels)
        return {};
    const std::vector<glm::dvec2> hull = hull_of(std::move(*pixels));
    return bands_of({&hull, 1}, frame.picture_size);
}

}  // namespace fumarole::surface
