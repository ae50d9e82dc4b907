#include "study/reference_emitters.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "overloaded.h"
#include "study/reference_directions.h"
#include "study/reference_sampling.h"

namespace fumarole::study {

namespace {

/// Areas of a box's sides that a point sees: two for each axis, of which one is 0 at least.
std::array<double, 6> seen_sides(const BoxSurface& box, glm::dvec3 p)
{
    const glm::dvec3 size = box.max - box.min;
    std::array<double, 6> areas{};
    for (int axis = 0; axis < 3; ++axis) {
        const double area = size[(axis + 1) % 3] * size[(axis + 2) % 3];
        const auto side = static_cast<std::size_t>(2 * axis);
        areas.at(side) = p[axis] < box.min[axis] ? area : 0;
        areas.at(side + 1) = p[axis] > box.max[axis] ? area : 0;
    }
    return areas;
}

/// 2 pi (1 - cos) of the cone that a sphere fills, seen from p; 0 from within.
double solid_angle_of(const SphereSurface& sphere, glm::dvec3 p)
{
    const glm::dvec3 to = sphere.center - p;
    const double sine2 = sphere.radius * sphere.radius / glm::dot(to, to);
    return sine2 < 1 ? 2 * std::numbers::pi * sine2 / (1 + std::sqrt(1 - sine2)) : 0;
}

/// Solid angle per area of a plane. [1/m^2]
double per_area(glm::dvec3 to, glm::dvec3 normal)
{
    const double d2 = glm::dot(to, to);
    return std::abs(glm::dot(to, normal)) / (d2 * std::sqrt(d2));
}

std::array<glm::dvec3, 3> corners_of(const MeshSurface& mesh, std::size_t triangle)
{
    std::array<glm::dvec3, 3> corners;
    for (std::size_t i = 0; i < 3; ++i)
        corners.at(i) =
            mesh.translate +
            mesh.scale * glm::dvec3(mesh.mesh->positions[mesh.mesh->triangles[3 * triangle + i]]);
    return corners;
}

}  // namespace

SurfaceEmitters::SurfaceEmitters(const std::vector<Surface>& surfaces)
{
    double all = 0;
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
        Emitter emitter;
        emitter.surface = static_cast<int>(i);
        emitter.shape = &surfaces[i];
        emitter.radiance =
            std::visit([](const auto& shape) { return glm::dvec3(shape.emission); }, surfaces[i]);
        if (emitter.radiance == glm::dvec3(0))
            continue;
        const double area = std::visit(
            Overloaded{[](const SphereSurface& sphere) {
                           return 4 * std::numbers::pi * sphere.radius * sphere.radius;
                       },
                       [](const BoxSurface& box) {
                           const glm::dvec3 s = box.max - box.min;
                           return 2 * (s.x * s.y + s.y * s.z + s.z * s.x);
                       },
                       [&](const MeshSurface& mesh) {
                           double sum = 0;
                           for (std::size_t t = 0;
                                mesh.mesh != nullptr && t < mesh.mesh->triangles.size() / 3; ++t) {
                               const auto [a, b, c] = corners_of(mesh, t);
                               sum += glm::length(glm::cross(b - a, c - a)) / 2;
                               emitter.triangles.push_back(sum);
                           }
                           return sum;
                       }},
            surfaces[i]);
        if (!(area > 0))
            continue;
        emitter.share = area * largest(emitter.radiance);
        shares_.push_back(all += emitter.share);
        emitters_.push_back(std::move(emitter));
    }
    for (Emitter& emitter : emitters_)
        emitter.share /= all;
}

SurfaceEmitters::Sample SurfaceEmitters::sample(glm::dvec3 p, double u, double v,
                                                double which) const
{
    const Emitter& emitter = emitters_[choose(shares_.data(), shares_.size(), which)];
    Sample sample = std::visit(
        Overloaded{[&](const SphereSurface& sphere) { return of_sphere(emitter, sphere, p, u, v); },
                   [&](const BoxSurface& box) { return of_box(emitter, box, p, u, v); },
                   [&](const MeshSurface& mesh) { return of_mesh(emitter, mesh, p, u, v); }},
        *emitter.shape);
    sample.pdf *= emitter.share;
    sample.radiance = emitter.radiance;
    return sample;
}

SurfaceEmitters::Sample SurfaceEmitters::of_sphere(const Emitter&, const SphereSurface& sphere,
                                                   glm::dvec3 p, double u, double v) const
{
    const double cone = solid_angle_of(sphere, p);
    if (!(cone > 0))
        return {};
    Sample out;
    out.pdf = 1 / cone;
    const glm::dvec3 to = sphere.center - p;
    out.wi = directed(glm::normalize(to), 1 - u * cone / (2 * std::numbers::pi),
                      2 * std::numbers::pi * v);
    const double b = glm::dot(to, out.wi);
    const glm::dvec3 foot = to - b * out.wi;
    out.range = b - std::sqrt(std::max(0.0, sphere.radius * sphere.radius - glm::dot(foot, foot)));
    return out;
}

SurfaceEmitters::Sample SurfaceEmitters::of_box(const Emitter&, const BoxSurface& box, glm::dvec3 p,
                                                double u, double v) const
{
    std::array<double, 6> sides = seen_sides(box, p);
    for (std::size_t i = 1; i < 6; ++i)
        sides.at(i) += sides.at(i - 1);
    if (!(sides[5] > 0))
        return {};
    const std::size_t side = choose(sides.data(), 6, u);
    const int axis = static_cast<int>(side / 2);
    glm::dvec3 place, normal(0);
    normal[axis] = 1;
    place[axis] = side % 2 == 0 ? box.min[axis] : box.max[axis];
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;
    place[a] = glm::mix(box.min[a], box.max[a], u);
    place[b] = glm::mix(box.min[b], box.max[b], v);
    Sample out;
    const glm::dvec3 to = place - p;
    out.range = glm::length(to);
    out.wi = to / out.range;
    out.pdf = 1 / (sides[5] * per_area(to, normal));
    return out;
}

SurfaceEmitters::Sample SurfaceEmitters::of_mesh(const Emitter& emitter, const MeshSurface& mesh,
                                                 glm::dvec3 p, double u, double v) const
{
    const std::size_t triangle = choose(emitter.triangles.data(), emitter.triangles.size(), u);
    const auto [a, b, c] = corners_of(mesh, triangle);
    const double r = std::sqrt(u);
    const glm::dvec3 place = (1 - r) * a + r * (1 - v) * b + r * v * c;
    const glm::dvec3 to = place - p, normal = glm::normalize(glm::cross(b - a, c - a));
    Sample out;
    out.range = glm::length(to);
    const double angle = emitter.triangles.back() * per_area(to, normal);
    if (!(angle > 0))
        return {};
    out.wi = to / out.range;
    out.pdf = 1 / angle;
    return out;
}

double SurfaceEmitters::pdf(glm::dvec3 p, const SurfaceHit& hit) const
{
    for (const Emitter& emitter : emitters_) {
        if (emitter.surface != hit.surface)
            continue;
        const auto by_area = [&](double area) {
            const double angle = area * per_area(hit.p - p, hit.normal);
            return angle > 0 ? emitter.share / angle : 0;
        };
        return std::visit(
            Overloaded{[&](const SphereSurface& sphere) {
                           const double cone = solid_angle_of(sphere, p);
                           return cone > 0 ? emitter.share / cone : 0;
                       },
                       [&](const BoxSurface& box) {
                           double area = 0;
                           for (const double side : seen_sides(box, p))
                               area += side;
                           return by_area(area);
                       },
                       [&](const MeshSurface&) { return by_area(emitter.triangles.back()); }},
            *emitter.shape);
    }
    return 0;
}

}  // namespace fumarole::study
