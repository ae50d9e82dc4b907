#pragma once

#include <cstdint>
#include <vector>

#include "light/depth_pyramid.h"
#include "light/light_set.h"
#include "pass/frame_setup.h"
#include "pass/step_slots.h"

namespace fumarole::pass {

/// How much of a sun's light surfaces let through to all points of a body.
enum class Shade { lit, dark, mixed };

/// A sun's shadow map as the CPU asks it.
class SunShade {
public:
    /// @param view a sun's @param texels the depths of its layer, size * size, row by row
    SunShade(const light::View& view, std::span<const float> texels, int size)
        : view_{view}, pyramid_{texels, size}
    {
    }

    /// Rays in the view: uv and depth, 0..1 each. eye: metres, world.
    [[nodiscard]] CameraRays seen(const CameraRays& rays, glm::dvec3 eye) const;

    /// Of the points on the rays of a rectangle of the picture, at any depth from view_z.x to
    /// view_z.y [m]. Mixed where it can't tell.
    /// @param rays of seen() @param ndc the rectangle's middle @param reach half its size
    [[nodiscard]] Shade over(const CameraRays& rays, glm::dvec2 ndc, glm::dvec2 reach,
                             glm::dvec2 view_z) const;

private:
    light::View view_;
    light::DepthPyramid pyramid_;
};

/// Where in a frame surfaces may hide a sun from the media.
class SunShades {
public:
    /// Reads the shadow maps of a scene that it has not met yet.
    void set(const light::LightSet& lights, const PassFrame& frame);

    /// Whether surfaces can hide a sun at all.
    [[nodiscard]] bool any() const { return !suns_.empty(); }

    /// In which of the slots that a rectangle of the picture holds a shadow may end, and whether
    /// none of them has any.
    void find(StepSlots::Held& held, const StepSlots& slots, glm::dvec2 ndc,
              glm::dvec2 reach) const;

private:
    struct Seen {
        SunShade shade;
        CameraRays rays;  ///< this frame's, of its view
    };
    std::vector<Seen> suns_;
    std::uint64_t scene_id_ = 0;
};

}  // namespace fumarole::pass
