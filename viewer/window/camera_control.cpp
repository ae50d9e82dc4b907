#include "window/camera_control.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>

namespace fumarole::window {

namespace {

constexpr double kPole = 0.02;  // radians that an eye stays away from straight up or down

double half_tangent(const Camera& camera)
{
    return std::tan(glm::radians(camera.vfov_deg) / 2);
}

/// A direction turned around `up` and then towards or away from it.
glm::dvec3 turned(glm::dvec3 direction, glm::dvec3 up, glm::dvec2 turn)
{
    const double length = glm::length(direction);
    glm::dvec3 d(glm::rotate(glm::dmat4(1), turn.x, up) * glm::dvec4(direction / length, 0));
    const double angle = std::acos(std::clamp(glm::dot(d, up), -1.0, 1.0));
    const double wanted = std::clamp(angle - turn.y, kPole, std::numbers::pi - kPole);
    const glm::dvec3 side = glm::cross(d, up);
    if (glm::length(side) > 1e-9)
        d = glm::dvec3(glm::rotate(glm::dmat4(1), angle - wanted, glm::normalize(side)) *
                       glm::dvec4(d, 0));
    return d * length;
}

double distance(const Camera& camera)
{
    return glm::length(camera.look_at - camera.position);
}

}  // namespace

glm::dmat3 axes_of(const Camera& camera)
{
    const glm::dvec3 forward = glm::normalize(camera.look_at - camera.position);
    const glm::dvec3 right = glm::normalize(glm::cross(forward, camera.up));
    return {right, glm::cross(right, forward), forward};
}

Camera orbited(const Camera& camera, glm::dvec2 turn)
{
    Camera moved = camera;
    moved.position = camera.look_at + turned(camera.position - camera.look_at,
                                             glm::normalize(camera.up), {-turn.x, -turn.y});
    return moved;
}

double metres_per_pixel(const Camera& camera, double view_z, double height)
{
    if (camera.projection == Camera::Projection::perspective)
        return 2 * half_tangent(camera) * view_z / height;
    const double whole =
        camera.ortho_height > 0 ? camera.ortho_height : 2 * half_tangent(camera) * distance(camera);
    return whole / height;
}

Camera panned(const Camera& camera, glm::dvec2 by, double height)
{
    const double scale = metres_per_pixel(camera, distance(camera), height);
    return flown(camera, {-by.x * scale, by.y * scale, 0});
}

Camera dollied(const Camera& camera, double factor)
{
    Camera moved = camera;
    if (camera.projection == Camera::Projection::orthographic && camera.ortho_height > 0) {
        moved.ortho_height *= factor;
        return moved;
    }
    const double wanted = std::clamp(distance(camera) * factor, camera.near, camera.far);
    moved.position = camera.look_at + glm::normalize(camera.position - camera.look_at) * wanted;
    return moved;
}

Camera looked_around(const Camera& camera, glm::dvec2 turn)
{
    Camera moved = camera;
    moved.look_at = camera.position + turned(camera.look_at - camera.position,
                                             glm::normalize(camera.up), {-turn.x, turn.y});
    return moved;
}

Camera flown(const Camera& camera, glm::dvec3 by)
{
    Camera moved = camera;
    const glm::dvec3 step = axes_of(camera) * by;
    moved.position += step;
    moved.look_at += step;
    return moved;
}

Camera fitted(const Camera& camera, const Bounds& what, double aspect)
{
    if (what.empty())
        return camera;
    constexpr double kMargin = 1.08;
    Camera moved = camera;
    const glm::dvec3 center = 0.5 * (what.min + what.max);
    const glm::dmat3 axes = axes_of(camera);
    const double tangent = half_tangent(camera);
    double back = 0, half_height = 0;
    for (int i = 0; i < 8; ++i) {
        const glm::dvec3 p = glm::transpose(axes) * (what.corner(i) - center);
        const double reach = std::max(std::abs(p.x) / aspect, std::abs(p.y)) * kMargin;
        back = std::max(back, reach / tangent - p.z);
        half_height = std::max(half_height, reach);
    }
    moved.look_at = center;
    moved.position = center - axes[2] * std::max(back, camera.near);
    if (camera.projection == Camera::Projection::orthographic)
        moved.ortho_height = 2 * half_height;
    moved.far = std::max(moved.far, back + what.diagonal());
    return moved;
}

Projected project(const Camera& camera, glm::dvec3 p, double aspect)
{
    const glm::dvec3 q = glm::transpose(axes_of(camera)) * (p - camera.position);
    const double half_height = metres_per_pixel(camera, q.z, 1) / 2;
    return {{0.5 + 0.5 * q.x / (half_height * aspect), 0.5 - 0.5 * q.y / half_height}, q.z};
}

}  // namespace fumarole::window
