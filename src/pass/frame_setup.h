#pragma once

#include "shared/frame_params.h"
#include <fumarole/bounds.h>
#include <fumarole/renderer.h>

#include "gl/device.h"

// From a host's matrices and depth convention to what the passes need.

namespace fumarole::pass {

/// A frame's camera, taken apart in double.
struct Eye {
    glm::dvec3 position{0};           ///< metres, world
    glm::dvec3 forward{0, 0, -1};     ///< unit length, world
    glm::dmat3 world_from_view{1.0};  ///< rotation
    double near = 0;                  ///< view_z of the near plane [m]
    double far = 0;                   ///< view_z of the far plane [m], may be infinite
    bool perspective = true;
};

/// A pixel's ray, p(view_z) = origin + direction * view_z in metres of eye-centred world; both are
/// affine in NDC: centre + x * dx + y * dy. Depth grows by 1 along a direction.
struct CameraRays {
    glm::dvec3 origin{0}, origin_dx{0}, origin_dy{0};
    glm::dvec3 direction{0}, direction_dx{0}, direction_dy{0};
};

/// Whether something of the frame is kept for the next one of its view.
bool keeps_history(const Frame& frame, const Settings& settings);

/// @throws Error if the projection is neither perspective nor orthographic or can't be inverted.
Eye make_eye(const Frame& frame);

CameraRays camera_rays(const Frame& frame, const Eye& eye);

/// Nearest and farthest view_z of a box [m].
glm::dvec2 view_z_range(const Eye& eye, const Bounds& bounds);

/// view_z within which media can be seen [m]; all the view's if there are none.
glm::dvec2 media_range(const Eye& eye, const Bounds& media);

/// What differences of depth are relative to [m]: the media's range where rays are parallel and
/// relative depth means nothing; 0: the depth itself.
double depth_reach(const Eye& eye, glm::dvec2 media_range);

/// view_z of the first and the last step's or slice's end [m]: the media's as far as they are in
/// view, or the camera's near and far.
glm::dvec2 step_range(const Eye& eye, const Bounds& media, const Settings& settings);

/// Largest value that a layer format holds.
float format_limit(Settings::Format format);
GLenum gl_format(Settings::Format format);

/// The frame's block. media: world bounds of all media, not empty.
shared::FrameParams make_frame_params(const Frame& frame, const Eye& eye, const Bounds& media,
                                      const Settings& settings);

/// Pixels along the edge of a texel of the volume layer, where that is left open: four where
/// neither a medium nor its light changes much within so many, else two.
/// @param detail metres within which the media change @param g the largest |g| of them
int layer_scale(const Frame& frame, const Eye& eye, const Bounds& media, double detail, double g);

/// Texels of the volume layer beyond the picture on each side, so that the upsample finds all its
/// taps at the picture's edge; 2017 had none and repeated its last.
int layer_guard(const Settings& settings);

/// Texels of the volume layer: half a texel at an odd edge counts whole.
glm::ivec2 layer_size(glm::ivec2 full, const Settings& settings);

}  // namespace fumarole::pass
