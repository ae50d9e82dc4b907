#pragma once

#include <optional>
#include <vector>

#include "light/depth_pyramid.h"
#include "light/light_set.h"
#include "pass/step_slots.h"
#include "prepared_frame.h"

namespace fumarole::pass {

/// How much of a sun's light surfaces let through to all points of a body.
enum class Shade { lit, dark, mixed };

/// A sun's shadow map as the CPU asks it.
class SunShade {
public:
    /// @param shadow outlives it
    explicit SunShade(const light::SunShadow& shadow) : shadow_{&shadow} {}

    /// Rays in the view: uv and depth, 0..1 each. eye: metres, world.
    [[nodiscard]] CameraRays seen(const CameraRays& rays, glm::dvec3 eye) const;

    /// Of the points on the rays of a rectangle of the picture, at any depth from view_z.x to
    /// view_z.y [m]. Mixed where it can't tell.
    /// @param rays of seen() @param ndc the rectangle's middle @param reach half its size
    [[nodiscard]] Shade over(const CameraRays& rays, glm::dvec2 ndc, glm::dvec2 reach,
                             glm::dvec2 view_z) const;

private:
    const light::SunShadow* shadow_;
};

/// Where in a frame surfaces may hide a sun from the media, or transparents filter it.
class SunShades {
public:
    /// Takes the shadow maps that are back from the GPU; while one is not, its sun may be hidden
    /// anywhere, which is never wrong and takes longer.
    void set(const light::LightSet& lights, const PreparedFrame& frame);

    /// Whether there are any.
    [[nodiscard]] bool any() const { return !suns_.empty() || !filtered_.empty(); }

    /// In which of the slots that a rectangle of the picture holds a shadow may end, and whether
    /// none of them has a surface's.
    void find(StepSlots::Held& held, const StepSlots& slots, glm::dvec2 ndc,
              glm::dvec2 reach) const;

private:
    struct Seen {
        std::optional<SunShade> shade;  ///< nothing: not known yet
        CameraRays rays;                ///< this frame's, of its view
    };
    /// A transparent that filters a sun.
    struct Filtered {
        const light::FilteredSun* sun = nullptr;
        CameraRays rays;  ///< this frame's, of its view

        [[nodiscard]] Shade over(glm::dvec2 ndc, glm::dvec2 reach, glm::dvec2 view_z) const;
    };
    std::vector<Seen> suns_;
    std::vector<Filtered> filtered_;
};

}  // namespace fumarole::pass
