#include <fumarole/scene.h>

#include <algorithm>
#include <cmath>

#include "blackbody.h"

namespace fumarole {

namespace {

/// Slope at key i [1/s]: the mean of the chords' beside it, each weighing as the other is long,
/// which is the parabola's through three keys. At an end the chord itself.
glm::dvec3 slope(const std::vector<CameraKey>& path, std::size_t i, glm::dvec3 Camera::*what)
{
    const auto chord = [&](std::size_t a) {
        return (path[a + 1].camera.*what - path[a].camera.*what) /
               (path[a + 1].time - path[a].time);
    };
    if (i == 0)
        return chord(0);
    if (i + 1 == path.size())
        return chord(i - 1);
    const double before = path[i].time - path[i - 1].time, after = path[i + 1].time - path[i].time;
    return (after * chord(i - 1) + before * chord(i)) / (before + after);
}

}  // namespace

double kelvin_per_unit(const GridMedium& medium)
{
    if (medium.temperature_scale > 0)
        return medium.temperature_scale;
    return guess_kelvin_per_unit(
        medium.temperature == nullptr ? 0 : static_cast<double>(medium.temperature->max_value));
}

bool glows_hot(const GridMedium& medium)
{
    return medium.temperature != nullptr && !medium.temperature->empty() &&
           medium.blackbody_intensity > 0 && medium.blackbody_tint != glm::vec3(0) &&
           static_cast<double>(medium.temperature->max_value) * kelvin_per_unit(medium) >
               kDarkKelvin;
}

bool can_cast(const Blend& blend)
{
    if (blend.kind != Blend::Kind::factors)
        return true;
    switch (blend.destination) {
    case BlendFactor::dst_color:
    case BlendFactor::one_minus_dst_color:
    case BlendFactor::dst_alpha:
    case BlendFactor::one_minus_dst_alpha:
    case BlendFactor::src_alpha_saturate:
        return false;
    default:
        return true;
    }
}

TransparentLook& look_of(Transparent& transparent)
{
    return std::visit([](auto& one) -> TransparentLook& { return one.look; }, transparent);
}

const TransparentLook& look_of(const Transparent& transparent)
{
    return std::visit([](const auto& one) -> const TransparentLook& { return one.look; },
                      transparent);
}

Camera camera_at(const std::vector<CameraKey>& path, double time)
{
    if (time <= path.front().time)
        return path.front().camera;
    if (time >= path.back().time)
        return path.back().camera;
    const auto next = std::upper_bound(path.begin(), path.end(), time,
                                       [](double t, const CameraKey& key) { return t < key.time; });
    const auto b = static_cast<std::size_t>(next - path.begin()), a = b - 1;
    const Camera &from = path[a].camera, &to = path[b].camera;
    const double h = path[b].time - path[a].time, u = (time - path[a].time) / h;
    const auto on_cubic = [&](glm::dvec3 Camera::*what) {
        const double u2 = u * u, u3 = u2 * u;
        return (2 * u3 - 3 * u2 + 1) * (from.*what) + (3 * u2 - 2 * u3) * (to.*what) +
               h * ((u3 - 2 * u2 + u) * slope(path, a, what) + (u3 - u2) * slope(path, b, what));
    };
    Camera camera = from;
    camera.position = on_cubic(&Camera::position);
    camera.look_at = on_cubic(&Camera::look_at);
    for (double Camera::*what :
         {&Camera::vfov_deg, &Camera::near, &Camera::far, &Camera::ortho_height})
        camera.*what = std::lerp(from.*what, to.*what, u);
    return camera;
}

bool same_content(const Scene& a, const Scene& b)
{
    const auto drifts = [](const Medium& medium) {
        const auto* box = std::get_if<BoxMedium>(&medium);
        const auto* noise = box != nullptr ? std::get_if<NoiseProfile>(&box->profile) : nullptr;
        return noise != nullptr && noise->drift != glm::dvec3(0);
    };
    return a.world == b.world && a.lights == b.lights && a.media == b.media &&
           a.surfaces == b.surfaces && a.transparents == b.transparents && a.probes == b.probes &&
           (a.time == b.time || std::none_of(a.media.begin(), a.media.end(), drifts));
}

}  // namespace fumarole
