#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include <fumarole/bounds.h>
#include <fumarole/scene.h>

namespace fumarole::window {

/// What one would look at: the grids' boxes, else the boxes of media, else the surfaces. World [m].
Bounds subject_of(const Scene& scene);

/// Where a light is dragged by. A sun's handle is on a sphere around the subject.
struct LightHandle {
    std::size_t light = 0;  ///< of Scene::lights
    glm::dvec2 at{0};       ///< 0..1 of the picture from its top left
};
std::vector<LightHandle> light_handles(const Scene& scene, double aspect);

/// The handle within `reach` pixels of a place, the nearest, or nothing.
std::optional<std::size_t> handle_at(const std::vector<LightHandle>& handles, glm::dvec2 place,
                                     glm::dvec2 pixels, double reach);

/// A light whose handle was dragged to a place: a sun turns, others move in the plane of the
/// picture at their depth.
Light dragged(const Scene& scene, const Light& light, glm::dvec2 to, double aspect);

}  // namespace fumarole::window
