#include "light/surface_rays.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "overloaded.h"
#include "ray_range.h"

namespace fumarole::light {

namespace {

constexpr double kNoHit = std::numeric_limits<double>::infinity();
/// Some hundred rays through so many take a tenth of a second.
constexpr std::size_t kMostTriangles = 100'000;

bool is_traced(const Mesh& mesh)
{
    return mesh.triangles.size() / 3 <= kMostTriangles;
}

Bounds bounds_around(const Surface& surface)
{
    Bounds bounds;
    std::visit(Overloaded{[&](const SphereSurface& sphere) {
                              bounds.add(sphere.center - sphere.radius);
                              bounds.add(sphere.center + sphere.radius);
                          },
                          [&](const BoxSurface& box) {
                              bounds.add(box.min);
                              bounds.add(box.max);
                          },
                          [&](const MeshSurface& mesh) {
                              if (mesh.mesh == nullptr)
                                  return;
                              for (const glm::vec3& p : mesh.mesh->positions)
                                  bounds.add(mesh.translate + mesh.scale * glm::dvec3(p));
                          }},
               surface);
    return bounds;
}

/// Beyond `origin`, from within too.
double range_to_sphere(const SphereSurface& sphere, glm::dvec3 origin, glm::dvec3 direction)
{
    const glm::dvec3 to = sphere.center - origin;
    const double b = glm::dot(to, direction);
    const double root = b * b - glm::dot(to, to) + sphere.radius * sphere.radius;
    if (root < 0)
        return kNoHit;
    const double near = b - std::sqrt(root), far = b + std::sqrt(root);
    return near > 0 ? near : far > 0 ? far : kNoHit;
}

double range_to_box(const Bounds& box, glm::dvec3 origin, glm::dvec3 direction)
{
    const glm::dvec2 range = ray_range(origin, direction, box);
    if (range.x >= range.y || range.y <= 0)
        return kNoHit;
    return range.x > 0 ? range.x : range.y;
}

struct MeshHit {
    double range = kNoHit;  ///< distance in the mesh's own metres
    bool back = false;      ///< true if it is a triangle's back
    int triangle = -1;
};

/// Moeller and Trumbore 1997, "Fast, Minimum Storage Ray/Triangle Intersection"; in the mesh's own
/// space.
MeshHit first_of_mesh(const Mesh& mesh, glm::dvec3 origin, glm::dvec3 direction)
{
    MeshHit hit;
    const auto at = [&](std::size_t i) { return glm::dvec3(mesh.positions[mesh.triangles[i]]); };
    for (std::size_t i = 0; i + 2 < mesh.triangles.size(); i += 3) {
        const glm::dvec3 a = at(i), ab = at(i + 1) - a, ac = at(i + 2) - a;
        const glm::dvec3 h = glm::cross(direction, ac);
        const double determinant = glm::dot(ab, h);
        if (determinant == 0)
            continue;
        const glm::dvec3 s = origin - a, q = glm::cross(s, ab);
        const double u = glm::dot(s, h) / determinant, v = glm::dot(direction, q) / determinant;
        const double t = glm::dot(ac, q) / determinant;
        if (u >= 0 && v >= 0 && u + v <= 1 && t > 0 && t < hit.range)
            hit = {t, determinant < 0, static_cast<int>(i / 3)};
    }
    return hit;
}

double distance_to_triangle(glm::dvec3 p, glm::dvec3 a, glm::dvec3 b, glm::dvec3 c)
{
    const auto to_edge = [&](glm::dvec3 from, glm::dvec3 to) {
        const glm::dvec3 way = to - from;
        const double along =
            glm::clamp(glm::dot(p - from, way) / std::max(glm::dot(way, way), 1e-300), 0.0, 1.0);
        return glm::distance(p, from + along * way);
    };
    const double edges = std::min({to_edge(a, b), to_edge(b, c), to_edge(c, a)});
    const glm::dvec3 n = glm::cross(b - a, c - a);
    const double size = glm::length(n);
    if (size == 0)
        return edges;
    const double height = glm::dot(p - a, n) / size;
    const glm::dvec3 foot = p - height * n / size;
    const bool over = glm::dot(glm::cross(b - a, foot - a), n) >= 0 &&
                      glm::dot(glm::cross(c - b, foot - b), n) >= 0 &&
                      glm::dot(glm::cross(a - c, foot - c), n) >= 0;
    return over ? std::abs(height) : edges;
}

}  // namespace

SurfaceRays::SurfaceRays(const std::vector<Surface>& surfaces) : surfaces_{surfaces}
{
    for (const Surface& surface : surfaces)
        bounds_.push_back(bounds_around(surface));
}

SurfaceRays::Hit SurfaceRays::hit_of(std::size_t surface, glm::dvec3 origin,
                                     glm::dvec3 direction) const
{
    const int index = static_cast<int>(surface);
    if (const auto* sphere = std::get_if<SphereSurface>(&surfaces_[surface]))
        return {range_to_sphere(*sphere, origin, direction), index};
    const Bounds& bounds = bounds_[surface];
    if (bounds.empty())
        return {kNoHit, index};
    const double to_bounds = range_to_box(bounds, origin, direction);
    const auto* mesh = std::get_if<MeshSurface>(&surfaces_[surface]);
    if (mesh == nullptr || to_bounds == kNoHit || !is_traced(*mesh->mesh))
        return {to_bounds, index};
    const MeshHit hit =
        first_of_mesh(*mesh->mesh, (origin - mesh->translate) / mesh->scale, direction);
    return {hit.range * mesh->scale, index, hit.triangle};
}

glm::dvec3 SurfaceRays::normal_of(const Hit& hit, glm::dvec3 p) const
{
    const auto surface = static_cast<std::size_t>(hit.surface);
    if (const auto* sphere = std::get_if<SphereSurface>(&surfaces_[surface]))
        return glm::normalize(p - sphere->center);
    if (hit.triangle >= 0) {
        const Mesh& mesh = *std::get<MeshSurface>(surfaces_[surface]).mesh;
        const std::size_t first = 3 * static_cast<std::size_t>(hit.triangle);
        const auto at = [&](std::size_t i) {
            return glm::dvec3(mesh.positions[mesh.triangles[first + i]]);
        };
        return glm::normalize(glm::cross(at(1) - at(0), at(2) - at(0)));
    }
    // The face of the box that it is nearest to.
    const Bounds& box = bounds_[surface];
    glm::dvec3 normal(0);
    double least = std::numeric_limits<double>::infinity();
    for (int face = 0; face < 6; ++face) {
        const int axis = face / 2;
        const double away = std::abs((face % 2 == 0 ? box.min : box.max)[axis] - p[axis]);
        if (away >= least)
            continue;
        least = away;
        normal = glm::dvec3(0);
        normal[axis] = face % 2 == 0 ? -1 : 1;
    }
    return normal;
}

std::optional<SurfaceRays::Hit> SurfaceRays::first(glm::dvec3 origin, glm::dvec3 direction,
                                                   const std::vector<bool>& left_out) const
{
    Hit hit{kNoHit, -1};
    for (std::size_t i = 0; i < surfaces_.size(); ++i) {
        if (i < left_out.size() && left_out[i])
            continue;
        if (const Hit one = hit_of(i, origin, direction); one.range < hit.range)
            hit = one;
    }
    if (hit.surface < 0)
        return {};
    return hit;
}

bool SurfaceRays::is_near(glm::dvec3 p, double metres, const std::vector<bool>& left_out) const
{
    for (std::size_t i = 0; i < surfaces_.size(); ++i) {
        if (!left_out.empty() && left_out[i])
            continue;
        if (const auto* sphere = std::get_if<SphereSurface>(&surfaces_[i])) {
            if (glm::distance(p, sphere->center) < sphere->radius + metres)
                return true;
            continue;
        }
        const Bounds& bounds = bounds_[i];
        if (bounds.empty() || glm::distance(p, glm::clamp(p, bounds.min, bounds.max)) > metres)
            continue;
        const auto* mesh = std::get_if<MeshSurface>(&surfaces_[i]);
        if (mesh == nullptr || !is_traced(*mesh->mesh))
            return true;
        // A mesh may be open: what sees its back in most of six directions is inside.
        const Mesh& own = *mesh->mesh;
        const glm::dvec3 q = (p - mesh->translate) / mesh->scale;
        const auto at = [&](std::size_t k) { return glm::dvec3(own.positions[own.triangles[k]]); };
        for (std::size_t k = 0; k + 2 < own.triangles.size(); k += 3)
            if (distance_to_triangle(q, at(k), at(k + 1), at(k + 2)) * mesh->scale < metres)
                return true;
        int backs = 0;
        for (int way = 0; way < 6; ++way) {
            glm::dvec3 direction(1e-3, 2e-3, 3e-3);  // along no edge
            direction[way / 2] += way % 2 == 0 ? 1 : -1;
            backs += first_of_mesh(own, q, direction).back ? 1 : 0;
        }
        if (backs > 3)
            return true;
    }
    return false;
}

// Roberts 2018, the sequence R3.
glm::dvec3 spread_place(const Bounds& box, int i)
{
    constexpr double kRoot = 1.2207440846057596;  // of x^4 = x + 1
    const glm::dvec3 at(1 / kRoot, 1 / (kRoot * kRoot), 1 / (kRoot * kRoot * kRoot));
    return glm::mix(box.min, box.max, glm::fract(0.5 + (i + 1.0) * at));
}

std::vector<glm::dvec3> even_directions(int count)
{
    std::vector<glm::dvec3> all;
    const double turn = std::numbers::pi * (3 - std::sqrt(5.0));
    for (int i = 0; i < count; ++i) {
        const double z = 1 - (2 * i + 1.0) / count, r = std::sqrt(1 - z * z);
        all.emplace_back(r * std::cos(turn * i), r * std::sin(turn * i), z);
    }
    return all;
}

}  // namespace fumarole::light
