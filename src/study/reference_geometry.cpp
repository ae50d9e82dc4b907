#include "study/reference_geometry.h"
#include "ray_range.h"
#include "study/reference_reflection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace fumarole::study {

namespace {

/// Both roots of a t^2 + 2 b t + c, ascending, without cancellation. None: NaN, which every
/// comparison refuses.
glm::dvec2 roots(double a, double b, double c)
{
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    const double d = b * b - a * c;
    if (!(d >= 0))
        return {kNone, kNone};
    const double q = -(b + std::copysign(std::sqrt(d), b));
    if (q == 0)
        return {0, a == 0 ? kNone : 0};
    const double t0 = c / q, t1 = a == 0 ? kNone : q / a;
    return t0 <= t1 ? glm::dvec2(t0, t1) : glm::dvec2(t1, t0);
}

glm::dvec2 sphere_range(const Ray& ray, const SphereSurface& sphere)
{
    const glm::dvec3 o = ray.origin - sphere.center;
    // The discriminant from the distance of ray and centre: it does not cancel far away.
    const double b = glm::dot(o, ray.direction);
    const glm::dvec3 foot = o - b * ray.direction;
    const double d = sphere.radius * sphere.radius - glm::dot(foot, foot);
    if (!(d > 0))
        return {kInfinity, -kInfinity};
    const double half = std::sqrt(d);
    return {-b - half, -b + half};
}

Bounds bounds_of(const BoxSurface& box)
{
    return {box.min, box.max};
}

}  // namespace

glm::dvec2 box_range(const Ray& ray, const Bounds& box)
{
    return ray_range(ray.origin, ray.direction, box);
}

void add_box_breaks(const Ray& ray, const Bounds& box, const LightPlace& light,
                    std::vector<double>& breaks)
{
    // Each edge and the light span a plane; the ray crosses it once.
    for (int axis = 0; axis < 3; ++axis) {
        glm::dvec3 along(0);
        along[axis] = 1;
        for (int side = 0; side < 4; ++side) {
            glm::dvec3 corner = box.min;
            const int u = (axis + 1) % 3, v = (axis + 2) % 3;
            if ((side & 1) != 0)
                corner[u] = box.max[u];
            if ((side & 2) != 0)
                corner[v] = box.max[v];
            const glm::dvec3 n = glm::cross(along, light.far ? light.at : light.at - corner);
            const double t = glm::dot(n, corner - ray.origin) / glm::dot(n, ray.direction);
            if (std::isfinite(t))
                breaks.push_back(t);
        }
        // A place on the box's own side.
        for (const double plane : {box.min[axis], box.max[axis]}) {
            const double t = (plane - ray.origin[axis]) / ray.direction[axis];
            if (std::isfinite(t))
                breaks.push_back(t);
        }
    }
}

// ------------------------------------------------------------------------------------ meshes

/// A tree of boxes over triangles, split at the middle of the longest side of their centres' box.
class ReferenceSurfaces::MeshTree {
public:
    MeshTree(const Mesh& mesh, glm::dvec3 translate, double scale) : mesh_{mesh}
    {
        for (const glm::vec3& p : mesh.positions)
            positions_.push_back(translate + scale * glm::dvec3(p));
        order_.resize(mesh.triangles.size() / 3);
        std::iota(order_.begin(), order_.end(), 0);
        if (!order_.empty())
            build(0, static_cast<int>(order_.size()));
    }

    [[nodiscard]] Bounds bounds() const { return nodes_.empty() ? Bounds{} : nodes_[0].bounds; }

    /// First triangle met in (begin, end); -1: none. `any`: whichever is found.
    int intersect(const Ray& ray, double begin, double& end, glm::dvec2& uv, bool any) const
    {
        int found = -1;
        std::array<int, 64> stack;
        int top = 0;
        if (!nodes_.empty())
            stack[0] = 0, top = 1;
        while (top > 0) {
            const Node& node =
                nodes_[static_cast<std::size_t>(stack[static_cast<std::size_t>(--top)])];
            const glm::dvec2 range = box_range(ray, node.bounds);
            if (!(std::max(range.x, begin) <= std::min(range.y, end)))
                continue;
            if (node.count == 0) {
                stack[static_cast<std::size_t>(top++)] = node.first;
                stack[static_cast<std::size_t>(top++)] = node.second;
                continue;
            }
            for (int i = node.first; i < node.first + node.count; ++i) {
                const int triangle = order_[static_cast<std::size_t>(i)];
                glm::dvec2 at(0);
                const double t = meet(ray, triangle, at);
                if (t > begin && t < end) {
                    end = t;
                    uv = at;
                    found = triangle;
                    if (any)
                        return found;
                }
            }
        }
        return found;
    }

    [[nodiscard]] glm::dvec3 normal(int triangle) const
    {
        const auto [a, b, c] = corners(triangle);
        return glm::normalize(glm::cross(b - a, c - a));
    }

    [[nodiscard]] glm::dvec3 shading_normal(int triangle, glm::dvec2 uv) const
    {
        if (mesh_.normals.size() != mesh_.positions.size())
            return normal(triangle);
        const glm::dvec3 n = (1 - uv.x - uv.y) * glm::dvec3(mesh_.normals[index(triangle, 0)]) +
                             uv.x * glm::dvec3(mesh_.normals[index(triangle, 1)]) +
                             uv.y * glm::dvec3(mesh_.normals[index(triangle, 2)]);
        return glm::dot(n, n) > 0 ? glm::normalize(n) : normal(triangle);
    }

private:
    struct Node {
        Bounds bounds;
        int first = 0;   ///< triangle in order_, or left child
        int second = 0;  ///< right child
        int count = 0;   ///< triangles; 0: an inner node
    };

    [[nodiscard]] std::size_t index(int triangle, std::size_t corner) const
    {
        return mesh_.triangles[static_cast<std::size_t>(triangle) * 3 + corner];
    }

    [[nodiscard]] std::array<glm::dvec3, 3> corners(int triangle) const
    {
        return {positions_[index(triangle, 0)], positions_[index(triangle, 1)],
                positions_[index(triangle, 2)]};
    }

    /// Möller and Trumbore 1997, both sides.
    double meet(const Ray& ray, int triangle, glm::dvec2& uv) const
    {
        const auto [a, b, c] = corners(triangle);
        const glm::dvec3 ab = b - a, ac = c - a, h = glm::cross(ray.direction, ac);
        const double det = glm::dot(ab, h);
        if (det == 0)
            return kInfinity;
        const glm::dvec3 s = ray.origin - a;
        uv.x = glm::dot(s, h) / det;
        const glm::dvec3 q = glm::cross(s, ab);
        uv.y = glm::dot(ray.direction, q) / det;
        if (!(uv.x >= 0 && uv.y >= 0 && uv.x + uv.y <= 1))
            return kInfinity;
        return glm::dot(ac, q) / det;
    }

    int build(int first, int last)
    {
        constexpr int kLeaf = 4;
        const auto id = static_cast<int>(nodes_.size());
        nodes_.emplace_back();
        Bounds all, centres;
        const auto centre = [&](int triangle) {
            const auto [a, b, c] = corners(triangle);
            return (a + b + c) / 3.0;
        };
        for (int i = first; i < last; ++i) {
            const int triangle = order_[static_cast<std::size_t>(i)];
            for (const glm::dvec3& p : corners(triangle))
                all.add(p);
            centres.add(centre(triangle));
        }
        // A triangle that lies in a plane of the axes must not fall out of a box of no depth.
        const glm::dvec3 rim = 1e-12 * (glm::abs(all.min) + glm::abs(all.max)) + 1e-300;
        nodes_[static_cast<std::size_t>(id)].bounds = {all.min - rim, all.max + rim};
        if (last - first <= kLeaf) {
            nodes_[static_cast<std::size_t>(id)].first = first;
            nodes_[static_cast<std::size_t>(id)].count = last - first;
            return id;
        }
        const glm::dvec3 size = centres.max - centres.min;
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
        // The median keeps the tree's depth at log2 of the triangles, whatever they are.
        const int middle = (first + last) / 2;
        std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + last,
                         [&](int a, int b) {
                             const double ca = centre(a)[axis], cb = centre(b)[axis];
                             return ca != cb ? ca < cb : a < b;
                         });
        const int left = build(first, middle), right = build(middle, last);
        nodes_[static_cast<std::size_t>(id)].first = left;
        nodes_[static_cast<std::size_t>(id)].second = right;
        return id;
    }

    const Mesh& mesh_;
    std::vector<glm::dvec3> positions_;
    std::vector<int> order_;
    std::vector<Node> nodes_;
};

// ---------------------------------------------------------------------------------- surfaces

ReferenceSurfaces::~ReferenceSurfaces() = default;
ReferenceSurfaces::ReferenceSurfaces(ReferenceSurfaces&&) noexcept = default;
ReferenceSurfaces& ReferenceSurfaces::operator=(ReferenceSurfaces&&) noexcept = default;

ReferenceSurfaces::ReferenceSurfaces(const std::vector<Surface>& surfaces) : surfaces_{&surfaces}
{
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
        Shape shape;
        shape.surface = static_cast<int>(i);
        if (const auto* sphere = std::get_if<SphereSurface>(&surfaces[i])) {
            shape.bounds = {sphere->center - sphere->radius, sphere->center + sphere->radius};
        } else if (const auto* box = std::get_if<BoxSurface>(&surfaces[i])) {
            shape.bounds = bounds_of(*box);
        } else if (const auto& mesh = std::get<MeshSurface>(surfaces[i]); mesh.mesh != nullptr) {
            shape.mesh = std::make_shared<MeshTree>(*mesh.mesh, mesh.translate, mesh.scale);
            shape.bounds = shape.mesh->bounds();
        } else {
            continue;
        }
        std::visit(
            [&](const auto& of) {
                if (of.gloss)
                    shape.gloss = std::make_shared<SurfaceGloss>(*of.gloss);
            },
            surfaces[i]);
        shapes_.push_back(std::move(shape));
    }
}

void ReferenceSurfaces::describe(const Shape& shape, const Ray& ray, glm::dvec2 uv,
                                 SurfaceHit& hit) const
{
    const Surface& surface = (*surfaces_)[static_cast<std::size_t>(shape.surface)];
    hit.surface = shape.surface;
    hit.p = ray.at(hit.t);
    hit.gloss = shape.gloss.get();
    std::visit(
        [&](const auto& of) {
            hit.albedo = of.albedo;
            hit.emission = of.emission;
        },
        surface);
    if (const auto* sphere = std::get_if<SphereSurface>(&surface)) {
        hit.normal = glm::normalize(hit.p - sphere->center);
        hit.shading = hit.normal;
    } else if (const auto* box = std::get_if<BoxSurface>(&surface)) {
        const glm::dvec3 half = (box->max - box->min) / 2.0;
        const glm::dvec3 q = (hit.p - (box->min + half)) / half;
        const glm::dvec3 a = glm::abs(q);
        const int axis = a.x >= a.y && a.x >= a.z ? 0 : (a.y >= a.z ? 1 : 2);
        hit.normal = glm::dvec3(0);
        hit.normal[axis] = q[axis] > 0 ? 1 : -1;
        hit.shading = hit.normal;
    } else {
        hit.normal = shape.mesh->normal(hit.triangle);
        hit.shading = shape.mesh->shading_normal(hit.triangle, uv);
    }
    // A mesh has two sides, and the one that faces the eye is meant.
    if (glm::dot(hit.normal, ray.direction) > 0)
        hit.normal = -hit.normal;
    if (glm::dot(hit.normal, hit.shading) < 0)
        hit.shading = -hit.shading;
}

std::optional<SurfaceHit> ReferenceSurfaces::intersect(const Ray& ray, double begin,
                                                       double end) const
{
    SurfaceHit hit;
    hit.t = end;
    const Shape* met = nullptr;
    glm::dvec2 uv(0);
    for (const Shape& shape : shapes_) {
        const Surface& surface = (*surfaces_)[static_cast<std::size_t>(shape.surface)];
        const auto first_of = [&](glm::dvec2 range) {
            if (!(range.x < range.y))
                return kInfinity;
            return range.x > begin ? range.x : (range.y > begin ? range.y : kInfinity);
        };
        double t = kInfinity;
        if (const auto* sphere = std::get_if<SphereSurface>(&surface)) {
            t = first_of(sphere_range(ray, *sphere));
        } else if (const auto* box = std::get_if<BoxSurface>(&surface)) {
            t = first_of(box_range(ray, bounds_of(*box)));
        } else if (shape.mesh != nullptr) {
            const int triangle = shape.mesh->intersect(ray, begin, hit.t, uv, false);
            if (triangle >= 0) {
                hit.triangle = triangle;
                met = &shape;
            }
            continue;
        }
        if (t < hit.t) {
            hit.t = t;
            met = &shape;
        }
    }
    if (met == nullptr)
        return std::nullopt;
    describe(*met, ray, uv, hit);
    return hit;
}

Origin ReferenceSurfaces::leave(const SurfaceHit& hit) const
{
    if (std::holds_alternative<MeshSurface>((*surfaces_)[static_cast<std::size_t>(hit.surface)])) {
        // Thousands of roundings of a double, millionths of what a mesh is made to.
        const double away =
            1e-10 * (1 + std::max({std::abs(hit.p.x), std::abs(hit.p.y), std::abs(hit.p.z)}));
        return {hit.p + away * hit.normal, -1, hit.normal};
    }
    return {hit.p, hit.surface, hit.normal};
}

bool ReferenceSurfaces::hidden(const Origin& from, glm::dvec3 wi, double range) const
{
    const Ray ray{from.p, wi};
    for (const Shape& shape : shapes_) {
        if (shape.surface == from.surface) {
            if (glm::dot(from.normal, wi) < 0)
                return true;
            continue;
        }
        const Surface& surface = (*surfaces_)[static_cast<std::size_t>(shape.surface)];
        glm::dvec2 met(kInfinity, -kInfinity);
        if (const auto* sphere = std::get_if<SphereSurface>(&surface)) {
            met = sphere_range(ray, *sphere);
        } else if (const auto* box = std::get_if<BoxSurface>(&surface)) {
            met = box_range(ray, bounds_of(*box));
        } else if (shape.mesh != nullptr) {
            glm::dvec2 uv(0);
            double end = range;
            if (shape.mesh->intersect(ray, 0, end, uv, true) >= 0)
                return true;
            continue;
        }
        if (met.x < met.y && met.y > 0 && std::max(met.x, 0.0) < range)
            return true;
    }
    return false;
}

template <class Found>
double ReferenceSurfaces::nearest(const Origin& from, glm::dvec3 wi, const Found& found) const
{
    const Ray ray{from.p, wi};
    double nearest = kInfinity;
    for (const Shape& shape : shapes_) {
        if (shape.surface == from.surface) {
            if (glm::dot(from.normal, wi) < 0) {
                found(nullptr, -1, glm::dvec2(0));
                return 0;
            }
            continue;
        }
        const Surface& surface = (*surfaces_)[static_cast<std::size_t>(shape.surface)];
        glm::dvec2 met(kInfinity, -kInfinity);
        if (const auto* sphere = std::get_if<SphereSurface>(&surface)) {
            met = sphere_range(ray, *sphere);
        } else if (const auto* box = std::get_if<BoxSurface>(&surface)) {
            met = box_range(ray, bounds_of(*box));
        } else if (shape.mesh != nullptr) {
            glm::dvec2 uv(0);
            const int triangle = shape.mesh->intersect(ray, 0, nearest, uv, false);
            if (triangle >= 0)
                found(&shape, triangle, uv);
            continue;
        }
        if (met.x < met.y && met.y > 0 && std::max(met.x, 0.0) < nearest) {
            nearest = std::max(met.x, 0.0);
            found(met.x > 0 ? &shape : nullptr, -1, glm::dvec2(0));
        }
    }
    return nearest;
}

double ReferenceSurfaces::distance(const Origin& from, glm::dvec3 wi) const
{
    return nearest(from, wi, [](const Shape*, int, glm::dvec2) {});
}

std::optional<SurfaceHit> ReferenceSurfaces::meet(const Origin& from, glm::dvec3 wi) const
{
    SurfaceHit hit;
    const Shape* met = nullptr;
    glm::dvec2 uv(0);
    hit.t = nearest(from, wi, [&](const Shape* shape, int triangle, glm::dvec2 at) {
        met = shape;
        hit.triangle = triangle;
        uv = at;
    });
    if (hit.t == kInfinity)
        return std::nullopt;
    if (met != nullptr)
        describe(*met, {from.p, wi}, uv, hit);
    return hit;
}

void ReferenceSurfaces::add_shadow_breaks(const Ray& ray, double begin, double end,
                                          const LightPlace& light,
                                          std::vector<double>& breaks) const
{
    const auto first = static_cast<std::ptrdiff_t>(breaks.size());
    bool meshes = false;
    for (const Shape& shape : shapes_) {
        const Surface& surface = (*surfaces_)[static_cast<std::size_t>(shape.surface)];
        if (const auto* sphere = std::get_if<SphereSurface>(&surface)) {
            const glm::dvec3 o = ray.origin - sphere->center;
            glm::dvec2 t;
            if (light.far) {
                // The cylinder that the sphere's shadow is.
                const glm::dvec3 a = o - glm::dot(o, light.at) * light.at;
                const glm::dvec3 b = ray.direction - glm::dot(ray.direction, light.at) * light.at;
                t = roots(glm::dot(b, b), glm::dot(a, b),
                          glm::dot(a, a) - sphere->radius * sphere->radius);
            } else {
                // The cone of tangents from the light: dot(p - l, axis)^2 = (D^2 - r^2) |p - l|^2
                // with axis = centre - l, D its length.
                const glm::dvec3 axis = sphere->center - light.at, a = ray.origin - light.at;
                const double k = glm::dot(axis, axis) - sphere->radius * sphere->radius;
                const double ua = glm::dot(a, axis), ub = glm::dot(ray.direction, axis);
                t = roots(ub * ub - k, ua * ub - k * glm::dot(a, ray.direction),
                          ua * ua - k * glm::dot(a, a));
            }
            for (const double root : {t.x, t.y})
                if (std::isfinite(root))
                    breaks.push_back(root);
        } else if (const auto* box = std::get_if<BoxSurface>(&surface)) {
            add_box_breaks(ray, bounds_of(*box), light, breaks);
        } else {
            meshes = true;
        }
    }
    const auto seen = [&](double t) {
        const glm::dvec3 p = ray.at(t);
        return !hidden({p, -1, glm::dvec3(0)}, light.wi(p), light.range(p));
    };
    if (meshes) {
        // A mesh has too many edges for a plane each: look, and halve where the answer changes.
        constexpr int kLooks = 128;
        const double far = std::min(end, 1e9);
        double t0 = begin;
        bool seen0 = seen(t0);
        for (int i = 1; i <= kLooks; ++i) {
            const double t1 = begin + (far - begin) * i / kLooks;
            const bool seen1 = seen(t1);
            if (seen1 != seen0) {
                double a = t0, b = t1;
                for (int halving = 0; halving < 40; ++halving) {
                    const double middle = (a + b) / 2;
                    (seen(middle) == seen0 ? a : b) = middle;
                }
                breaks.push_back(b);
            }
            t0 = t1;
            seen0 = seen1;
        }
    }
    // Of the closed forms' candidates, those that change something.
    const auto out = [&](double t) { return !(t > begin && t < end); };
    breaks.erase(std::remove_if(breaks.begin() + first, breaks.end(), out), breaks.end());
    std::sort(breaks.begin() + first, breaks.end());
    std::vector<double> kept;
    double before = begin;
    std::optional<bool> seen_before;
    for (auto i = first; i <= static_cast<std::ptrdiff_t>(breaks.size()); ++i) {
        const bool last = i == static_cast<std::ptrdiff_t>(breaks.size());
        const double t = last ? end : breaks[static_cast<std::size_t>(i)];
        const double middle = std::isfinite(t) ? (before + t) / 2 : before + 1;
        const bool now = seen(middle);
        if (seen_before && *seen_before != now)
            kept.push_back(before);
        seen_before = now;
        before = t;
    }
    breaks.erase(breaks.begin() + first, breaks.end());
    breaks.insert(breaks.end(), kept.begin(), kept.end());
}

}  // namespace fumarole::study
