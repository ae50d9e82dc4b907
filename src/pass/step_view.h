#pragma once

#include <algorithm>
#include <glm/glm.hpp>
#include <glm/gtc/constants.hpp>
#include <vector>

#include "pass/step_slots.h"
#include "prepared_frame.h"

namespace fumarole::pass {

/// A light that has a place, beside the rays of a picture.
struct NearLight {
    NearLight(glm::dvec3 position, const Frame& frame, double near);

    /// Metres, about, between it and the ray of a pixel.
    [[nodiscard]] double from_ray(glm::dvec2 at) const
    {
        return std::max(least, metres * glm::length(at - pixel));
    }

    /// Metres, about, that it is at least from all that lies up to `radius` pixels beside a pixel
    /// and from view_z.x to view_z.y [m].
    [[nodiscard]] double from_tile(glm::dvec2 at, double radius, glm::dvec2 z) const
    {
        const double beside = metres * (glm::length(at - pixel) - radius);
        return std::max(std::max(least, beside), std::max(z.x - view_z, view_z - z.y));
    }

    glm::dvec2 pixel{0};
    double view_z = 0;  ///< [m]
    double metres = 0;  ///< of a pixel, where the light is
    double least = 0;   ///< of a light behind the eye
};

/// What the tiles of a frame are worked out from, on the CPU or by compute shaders.
struct StepView {
    const PreparedFrame& frame;
    StepSlots slots;
    double scale;       ///< pixels of a texel
    glm::dvec2 offset;  ///< of the layer's first texel from the picture's, in texels
    double reach;       ///< of the layer's texels that a pixel is made of, those on either side

    std::vector<NearLight> lights;  ///< beside which light has detail of its own
    bool spaced = false;            ///< steps are as long as the media let them be
    bool lit = false;               ///< no surface hides a light from any tile
    bool shafts_anywhere = false;   ///< a shadow may end in any step
    /// Of a light's distance that a step may have which it is far from; 0: none is.
    double far_share = 0;

    static constexpr double kSlack = 0.01;  ///< texels, and pixels
    /// Of view_z: rays and bricks are worked out by other sums on the GPU.
    static constexpr double kDepthRounding = 1e-5;

    explicit StepView(const PreparedFrame& of);

    /// Pixels from a tile's middle to its corner.
    [[nodiscard]] double tile_radius() const
    {
        return glm::root_two<double>() / 2 * shared::kLayerTile * scale;
    }

    /// How long a step may be [m] in which a surface's shadow ends, where media extinguish one part
    /// per metre: it may do so anywhere in it. What it misses is grain, which shows the more the
    /// more pixels a texel's edge has.
    [[nodiscard]] double shaft() const
    {
        constexpr double kShaft = 0.16;  // optical depth times pixels
        return kShaft / std::max(frame.settings.resolution, 2);
    }
};

/// Of a light's distance that a step may have which it is far from, in media of such g: what
/// 1/d^2 does over it is a parabola to 2.5e-4 (glsl/scene/in_scattering.glsl), and the angle that
/// the light sees it under a quarter of what a phase's lobe changes within.
double far_share(double g);

/// How long a step may be [m] in a medium that changes within `detail` metres and extinguishes
/// `most` per metre: as long as its detail asks, or longer where there is next to nothing of it.
float longest_step(double detail, double most);

}  // namespace fumarole::pass
