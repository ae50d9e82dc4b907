#pragma once

#include <glm/glm.hpp>

#include <fumarole/bounds.h>
#include <fumarole/scene.h>

// How a hand moves a camera. Pure: a camera in, a camera out.

namespace fumarole::window {

/// Around look_at. @param turn of the picture, radians: x to the right, y upwards; never over a
/// pole
Camera orbited(const Camera& camera, glm::dvec2 turn);

/// Sideways, so that what lies at look_at's depth follows the pointer.
/// @param by pixels, x to the right, y down @param height of the picture, pixels
Camera panned(const Camera& camera, glm::dvec2 by, double height);

/// Towards look_at: the distance is multiplied by `factor`, > 0. Orthographic: the height is.
Camera dollied(const Camera& camera, double factor);

/// The eye turns where it is. @param turn as orbited()
Camera looked_around(const Camera& camera, glm::dvec2 turn);

/// Along its own axes, its target too. @param by metres: right, up, forward
Camera flown(const Camera& camera, glm::dvec3 by);

/// From where it looks, back until `what` fills the picture. @param aspect width over height
Camera fitted(const Camera& camera, const Bounds& what, double aspect);

/// Metres that a pixel spans at a distance along the view axis.
double metres_per_pixel(const Camera& camera, double view_z, double height);

struct Projected {
    glm::dvec2 at{0};   ///< 0..1 of the picture from its top left; outside too
    double view_z = 0;  ///< metres; behind the eye if not above 0
};
Projected project(const Camera& camera, glm::dvec3 p, double aspect);

/// The unit vector right, up and forward of a camera, in columns, world space.
glm::dmat3 axes_of(const Camera& camera);

}  // namespace fumarole::window
