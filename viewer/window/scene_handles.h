#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include <fumarole/bounds.h>
#include <fumarole/scene.h>

namespace fumarole::window {

/// What one would look at: the grids' boxes, else the boxes of media, else the surfaces. World [m].
Bounds subject_of(const Scene& scene);

/// What a light, a probe or a transparent is dragged by.
struct Handle {
    std::size_t index = 0;  ///< place in Scene::lights, probes or transparents
    glm::dvec2 at{0};       ///< 0..1 of the picture from its top left
};
/// A sun's is on a sphere around the subject.
std::vector<Handle> light_handles(const Scene& scene, double aspect);
/// Between the two balls that stand for each.
std::vector<Handle> probe_handles(const Scene& scene, double aspect);
/// Of those balls: a part of what one looks at [m].
double probe_ball_radius(const Scene& scene);
/// In the middle of each.
std::vector<Handle> transparent_handles(const Scene& scene, double aspect);

/// The handle within `reach` pixels of a place, the nearest, or nothing.
std::optional<std::size_t> handle_at(const std::vector<Handle>& handles, glm::dvec2 place,
                                     glm::dvec2 pixels, double reach);

/// A light whose handle was dragged to a place: a sun turns, others move in the plane of the
/// picture at their depth.
Light dragged(const Scene& scene, const Light& light, glm::dvec2 to, double aspect);
/// Likewise, in the plane of the picture.
LightProbe dragged(const Scene& scene, const LightProbe& probe, glm::dvec2 to, double aspect);
Transparent dragged(const Scene& scene, const Transparent& transparent, glm::dvec2 to,
                    double aspect);

/// The place that a transparent is moved by: a quad's corner, a billboard's middle.
glm::dvec3& place_of(Transparent& transparent);
const char* transparent_name(const Transparent& transparent);

}  // namespace fumarole::window
