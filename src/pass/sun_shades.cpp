#include "pass/sun_shades.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace fumarole::pass {

namespace {

/// Rays in a sun's view: uv and depth, 0..1 each.
CameraRays rays_in(const light::View& view, const CameraRays& rays, glm::dvec3 eye)
{
    // As visibility_in() of glsl/scene/lights.glsl looks a point up.
    const auto turned = [&](glm::dvec3 d) {
        const glm::dvec4 clip = view.clip_from_world * glm::dvec4(d, 0.0);
        return glm::dvec3(glm::dvec2(clip) * 0.5, glm::dot(d, view.axis) / view.range);
    };
    CameraRays out;
    out.origin = turned(rays.origin + eye - view.origin) + glm::dvec3(0.5, 0.5, 0);
    out.origin_dx = turned(rays.origin_dx);
    out.origin_dy = turned(rays.origin_dy);
    out.direction = turned(rays.direction);
    out.direction_dx = turned(rays.direction_dx);
    out.direction_dy = turned(rays.direction_dy);
    return out;
}

/// Around all points on the rays of a rectangle of the picture from view_z.x to view_z.y [m].
struct Extent {
    glm::dvec3 low, high;
};

Extent extent_of(const CameraRays& rays, glm::dvec2 ndc, glm::dvec2 reach, glm::dvec2 view_z)
{
    const auto spread = [&](glm::dvec3 dx, glm::dvec3 dy) {
        return glm::abs(dx) * reach.x + glm::abs(dy) * reach.y;
    };
    const glm::dvec3 origin = rays.origin + rays.origin_dx * ndc.x + rays.origin_dy * ndc.y;
    const glm::dvec3 origin_spread = spread(rays.origin_dx, rays.origin_dy);
    const glm::dvec3 direction =
        rays.direction + rays.direction_dx * ndc.x + rays.direction_dy * ndc.y;
    const glm::dvec3 direction_spread = spread(rays.direction_dx, rays.direction_dy);
    const auto end = [&](double z) {
        const glm::dvec3 middle = origin + direction * z;
        const glm::dvec3 around = origin_spread + direction_spread * std::abs(z);
        return std::pair{middle - around, middle + around};
    };
    const auto [low_near, high_near] = end(view_z.x);
    const auto [low_far, high_far] = end(view_z.y);
    return {glm::min(low_near, low_far), glm::max(high_near, high_far)};
}

}  // namespace

CameraRays SunShade::seen(const CameraRays& rays, glm::dvec3 eye) const
{
    return rays_in(shadow_->view, rays, eye);
}

Shade SunShade::over(const CameraRays& rays, glm::dvec2 ndc, glm::dvec2 reach,
                     glm::dvec2 view_z) const
{
    const auto [low, high] = extent_of(rays, ndc, reach, view_z);
    const light::DepthPyramid::Extent kept =
        shadow_->depths.over(glm::dvec2(low), glm::dvec2(high));
    constexpr double kRounding = 1e-5;  // of depth: floats on the GPU, doubles here
    // A lookup clamps its depth.
    if (std::min(high.z, 1.0) + kRounding < static_cast<double>(kept.least) || kept.least >= 1)
        return Shade::lit;
    if (std::min(low.z, 1.0) - kRounding > static_cast<double>(kept.most))
        return Shade::dark;
    return Shade::mixed;
}

/// What lies behind one is never taken to be the same all over: it may have a hole, or an image.
Shade SunShades::Filtered::over(glm::dvec2 ndc, glm::dvec2 reach, glm::dvec2 view_z) const
{
    const auto [low, high] = extent_of(rays, ndc, reach, view_z);
    constexpr double kRounding = 1e-5;  // as above
    const bool beside = glm::any(glm::lessThan(glm::dvec2(high), sun->low - kRounding)) ||
                        glm::any(glm::greaterThan(glm::dvec2(low), sun->high + kRounding));
    return beside || high.z + kRounding < sun->first ? Shade::lit : Shade::mixed;
}

void SunShades::set(const light::LightSet& lights, const PreparedFrame& frame)
{
    suns_.clear();
    filtered_.clear();
    for (const light::FilteredSun& sun : lights.filters().filtered_suns())
        filtered_.push_back({&sun, rays_in(sun.view, frame.rays, frame.eye.position)});
    if (!lights.shaded_media())
        return;
    for (int i = 0; i < lights.suns(); ++i) {
        Seen& sun = suns_.emplace_back();
        if (const light::SunShadow* shadow = lights.sun_shadow(i)) {
            sun.shade.emplace(*shadow);
            sun.rays = sun.shade->seen(frame.rays, frame.eye.position);
        }
    }
}

void SunShades::find(StepSlots::Held& held, const StepSlots& slots, glm::dvec2 ndc,
                     glm::dvec2 reach) const
{
    held.lit = true;
    // Halves of a row of slots, until one is all of a kind.
    const auto look = [&](const auto& over, bool hides, int first, int last, const auto& again) {
        if ((held.slots & StepSlots::row(first, last)) == 0)
            return;
        const Shade shade = over({slots.begin(first), slots.begin(last)});
        if (shade == Shade::lit)
            return;
        held.lit &= !hides;
        if (shade == Shade::dark)
            return;
        const int units = (last - first + slots.unit() - 1) / slots.unit();
        if (units == 1) {
            held.shafts |= StepSlots::row(first, last);
            return;
        }
        const int middle = first + units / 2 * slots.unit();
        again(over, hides, first, middle, again);
        again(over, hides, middle, last, again);
    };
    const std::uint64_t bits = held.slots;
    const int first_slot = std::countr_zero(bits) / slots.unit() * slots.unit();
    const int end = std::min(slots.count(), 64 - std::countl_zero(bits));
    for (const Filtered& sun : filtered_)
        look([&](glm::dvec2 view_z) { return sun.over(ndc, reach, view_z); }, false, first_slot,
             end, look);
    for (const Seen& sun : suns_) {
        if (!sun.shade) {
            held.lit = false;
            held.shafts = slots.all();
            continue;
        }
        look([&](glm::dvec2 view_z) { return sun.shade->over(sun.rays, ndc, reach, view_z); }, true,
             first_slot, end, look);
    }
}

}  // namespace fumarole::pass
