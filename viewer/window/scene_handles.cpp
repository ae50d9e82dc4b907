#include "window/scene_handles.h"

#include <algorithm>
#include <cmath>

#include "light_fields.h"
#include "overloaded.h"
#include "window/camera_control.h"

namespace fumarole::window {

namespace {

Bounds of_grid(const GridMedium& medium)
{
    Bounds bounds;
    if (medium.density == nullptr)
        return bounds;
    const VoxelGrid& grid = *medium.density;
    bounds.min = glm::dvec3(grid.index_min) - 0.5;
    bounds.max = glm::dvec3(grid.index_max) + 0.5;
    bounds = bounds.transformed(grid.world_from_index);
    bounds.min = medium.translate + medium.scale * bounds.min;
    bounds.max = medium.translate + medium.scale * bounds.max;
    return bounds;
}

Bounds of_surface(const Surface& surface)
{
    Bounds bounds;
    if (const auto* box = std::get_if<BoxSurface>(&surface)) {
        bounds.min = box->min;
        bounds.max = box->max;
    } else if (const auto* sphere = std::get_if<SphereSurface>(&surface)) {
        bounds.min = sphere->center - sphere->radius;
        bounds.max = sphere->center + sphere->radius;
    } else if (const auto& mesh = std::get<MeshSurface>(surface); mesh.mesh != nullptr) {
        for (const glm::vec3& p : mesh.mesh->positions)
            bounds.add(mesh.translate + mesh.scale * glm::dvec3(p));
    }
    return bounds;
}

/// The sphere that suns are dragged on.
struct Dome {
    glm::dvec3 center;
    double radius;

    Dome(const Scene& scene, double aspect)
    {
        const Bounds subject = subject_of(scene);
        center = subject.empty() ? scene.camera.look_at : 0.5 * (subject.min + subject.max);
        // Within the picture of an eye that looks at the subject.
        constexpr double kShare = 0.8;
        const double away = glm::length(scene.camera.position - center);
        radius = kShare * metres_per_pixel(scene.camera, away, 1) / 2 * std::min(1.0, aspect);
    }
};

glm::dvec3 position_of(const Light& light, const Dome& dome)
{
    const LightPosition place = fumarole::position_of(light);
    return place.far ? dome.center + place.at * dome.radius : place.at;
}

/// The point of the sphere under a place of the picture, of two the one that is nearer to `like`;
/// beside the sphere its rim.
glm::dvec3 on_dome(const Dome& dome, const Camera& camera, glm::dvec2 place, double aspect,
                   glm::dvec3 like)
{
    const glm::dmat3 axes = axes_of(camera);
    const double half = metres_per_pixel(camera, 1, 1) / 2;
    const glm::dvec3 across =
        axes * glm::dvec3((2 * place.x - 1) * half * aspect, (1 - 2 * place.y) * half, 0);
    const bool perspective = camera.projection == Camera::Projection::perspective;
    const glm::dvec3 origin = perspective ? camera.position : camera.position + across;
    const glm::dvec3 d = perspective ? glm::normalize(axes[2] + across) : axes[2];
    const double foot = glm::dot(dome.center - origin, d);
    const glm::dvec3 nearest = origin + foot * d - dome.center;
    const double rest = dome.radius * dome.radius - glm::dot(nearest, nearest);
    if (rest <= 0)
        return glm::normalize(nearest);
    const glm::dvec3 front = nearest - std::sqrt(rest) * d, back = nearest + std::sqrt(rest) * d;
    return glm::normalize(glm::dot(front, like) > glm::dot(back, like) ? front : back);
}

/// From a place, at its depth, to where it is seen at `to`.
glm::dvec3 across_picture(const Camera& camera, glm::dvec3 from, glm::dvec2 to, double aspect)
{
    const Projected there = project(camera, from, aspect);
    const double height = metres_per_pixel(camera, there.view_z, 1);
    const glm::dvec2 by = (to - there.at) * glm::dvec2(aspect, -1) * height;
    const glm::dmat3 axes = axes_of(camera);
    return axes[0] * by.x + axes[1] * by.y;
}

glm::dvec3 middle_of(const Transparent& transparent)
{
    return std::visit(Overloaded{[](const QuadTransparent& quad) {
                                     return quad.corner + (quad.edges[0] + quad.edges[1]) / 2.0;
                                 },
                                 [](const BillboardTransparent& board) { return board.center; },
                                 [](const MeshTransparent& mesh) {
                                     Bounds bounds;
                                     if (mesh.mesh != nullptr)
                                         for (const glm::vec3& p : mesh.mesh->positions)
                                             bounds.add(glm::dvec3(p));
                                     if (bounds.empty())
                                         return mesh.translate;
                                     return mesh.translate +
                                            mesh.scale * (bounds.min + bounds.max) / 2.0;
                                 }},
                      transparent);
}

}  // namespace

Bounds subject_of(const Scene& scene)
{
    Bounds grids, boxes, surfaces;
    for (const Medium& medium : scene.media)
        std::visit(Overloaded{[&](const GridMedium& grid) { grids.add(of_grid(grid)); },
                              [&](const BoxMedium& box) {
                                  boxes.add(box.min);
                                  boxes.add(box.max);
                              }},
                   medium);
    for (const Surface& surface : scene.surfaces)
        surfaces.add(of_surface(surface));
    return !grids.empty() ? grids : !boxes.empty() ? boxes : surfaces;
}

std::vector<Handle> light_handles(const Scene& scene, double aspect)
{
    const Dome dome(scene, aspect);
    std::vector<Handle> handles;
    for (std::size_t i = 0; i < scene.lights.size(); ++i)
        if (const Projected p = project(scene.camera, position_of(scene.lights[i], dome), aspect);
            p.view_z > scene.camera.near)
            handles.push_back({i, p.at});
    return handles;
}

std::vector<Handle> probe_handles(const Scene& scene, double aspect)
{
    std::vector<Handle> handles;
    for (std::size_t i = 0; i < scene.probes.size(); ++i)
        if (const Projected p = project(scene.camera, scene.probes[i].position, aspect);
            p.view_z > scene.camera.near)
            handles.push_back({i, p.at});
    return handles;
}

std::vector<Handle> transparent_handles(const Scene& scene, double aspect)
{
    std::vector<Handle> handles;
    for (std::size_t i = 0; i < scene.transparents.size(); ++i)
        if (const Projected p = project(scene.camera, middle_of(scene.transparents[i]), aspect);
            p.view_z > scene.camera.near)
            handles.push_back({i, p.at});
    return handles;
}

const char* transparent_name(const Transparent& transparent)
{
    return std::visit(Overloaded{[](const QuadTransparent&) { return "quad"; },
                                 [](const BillboardTransparent&) { return "billboard"; },
                                 [](const MeshTransparent&) { return "mesh"; }},
                      transparent);
}

glm::dvec3& place_of(Transparent& transparent)
{
    return std::visit(
        Overloaded{[](QuadTransparent& quad) -> glm::dvec3& { return quad.corner; },
                   [](BillboardTransparent& board) -> glm::dvec3& { return board.center; },
                   [](MeshTransparent& mesh) -> glm::dvec3& { return mesh.translate; }},
        transparent);
}

std::optional<std::size_t> handle_at(const std::vector<Handle>& handles, glm::dvec2 place,
                                     glm::dvec2 pixels, double reach)
{
    std::optional<std::size_t> found;
    for (const Handle& handle : handles)
        if (const double away = glm::length((handle.at - place) * pixels); away <= reach) {
            reach = away;
            found = handle.index;
        }
    return found;
}

double probe_ball_radius(const Scene& scene)
{
    constexpr double kPart = 0.05;
    const Bounds subject = subject_of(scene);
    return subject.empty() ? kPart : kPart * subject.diagonal();
}

Light dragged(const Scene& scene, const Light& light, glm::dvec2 to, double aspect)
{
    const Dome dome(scene, aspect);
    const Camera& camera = scene.camera;
    Light moved = light;
    if (const LightPosition place = fumarole::position_of(light); place.far) {
        move_to(moved, on_dome(dome, camera, to, aspect, place.at));
        return moved;
    }
    const glm::dvec3 from = position_of(light, dome);
    move_to(moved, from + across_picture(camera, from, to, aspect));
    return moved;
}

LightProbe dragged(const Scene& scene, const LightProbe& probe, glm::dvec2 to, double aspect)
{
    LightProbe moved = probe;
    moved.position += across_picture(scene.camera, probe.position, to, aspect);
    return moved;
}

Transparent dragged(const Scene& scene, const Transparent& transparent, glm::dvec2 to,
                    double aspect)
{
    Transparent moved = transparent;
    place_of(moved) += across_picture(scene.camera, middle_of(transparent), to, aspect);
    return moved;
}

}  // namespace fumarole::window
