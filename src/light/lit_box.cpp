#include "light/lit_box.h"

#include <algorithm>

namespace fumarole::light {

const surface::SurfaceSet::Instance*
lone_box(const Bounds& around, std::span<const surface::SurfaceSet::Instance> surfaces)
{
    const auto is_near = [&](const surface::SurfaceSet::Instance& instance) {
        return instance.bounds.meets(around);
    };
    const auto first = std::find_if(surfaces.begin(), surfaces.end(), is_near);
    if (first == surfaces.end() || !first->is_box ||
        std::any_of(first + 1, surfaces.end(), is_near))
        return nullptr;
    return &*first;
}

Bounds lit_box(const Bounds& around, const Bounds& media,
               std::span<const surface::SurfaceSet::Instance> surfaces, double spacing)
{
    const surface::SurfaceSet::Instance* alone = lone_box(around, surfaces);
    if (alone == nullptr)
        return around;
    // With so much beyond the ground, in parts of what is lit, it lies clear of SURFACES_RIM, in
    // which light fades towards the volume's faces, and with so many nodes a lookup over it has its
    // eight.
    constexpr double kFadingRoom = 0.25, kNodes = 2;
    const Bounds ground = alone->bounds.common(around);
    Bounds lit = media;
    lit.add(ground);
    const glm::dvec3 room = kFadingRoom * (lit.max - lit.min), least(kNodes * spacing);
    lit.min -= glm::max(room - (ground.min - lit.min), least);
    lit.max += glm::max(room - (lit.max - ground.max), least);
    return lit.common(around);
}

}  // namespace fumarole::light
