#include "light/lit_box.h"

#include <algorithm>

namespace fumarole::light {

Bounds lit_box(const Bounds& around, const Bounds& media,
               std::span<const surface::SurfaceSet::Instance> surfaces, double spacing)
{
    const auto part_of = [&](const surface::SurfaceSet::Instance& instance) {
        return Bounds{glm::max(instance.bounds.min, around.min),
                      glm::min(instance.bounds.max, around.max)};
    };
    const auto is_near = [&](const surface::SurfaceSet::Instance& instance) {
        const Bounds part = part_of(instance);
        return glm::all(glm::lessThanEqual(part.min, part.max));
    };
    const auto alone = std::find_if(surfaces.begin(), surfaces.end(), is_near);
    if (alone == surfaces.end() || !alone->is_box ||
        std::any_of(alone + 1, surfaces.end(), is_near))
        return around;
    // With so much beyond the ground, in parts of what is lit, it lies clear of the 0.15 of the
    // volume in which light fades towards its faces, and with so many nodes a lookup over it has
    // its eight.
    constexpr double kFadingRoom = 0.25, kNodes = 2;
    const Bounds ground = part_of(*alone);
    Bounds lit = media;
    lit.add(ground);
    const glm::dvec3 room = kFadingRoom * (lit.max - lit.min), least(kNodes * spacing);
    lit.min -= glm::max(room - (ground.min - lit.min), least);
    lit.max += glm::max(room - (lit.max - ground.max), least);
    return {glm::max(lit.min, around.min), glm::min(lit.max, around.max)};
}

}  // namespace fumarole::light
