#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "study/reference.h"
#include <fumarole/bounds.h>
#include <fumarole/scene.h>
#include <fumarole/settings.h>

// What a scene needs and what it does without, in words.

namespace fumarole::medium {
struct MediaTraits;  // medium/media_set.h
}

namespace fumarole::study {

/// Something about a scene that makes its picture cheaper.
struct PlanFact {
    std::string text;
    /// A setting and its value that put back what the scene does without, where there is one.
    std::optional<std::pair<std::string, std::string>> without = std::nullopt;
    /// Of the time that the volume takes then, the share that is saved: 0.27. Where it was
    /// measured.
    std::optional<double> saving = std::nullopt;
    /// The picture's error with what is chosen, and without this: the root of relMSE. Where it was
    /// measured: of what is there for the picture's sake.
    std::optional<std::pair<double, double>> errors = std::nullopt;
};

/// Media this thin neither dim light nor each other as far as anyone sees.
inline constexpr double kThin = 0.02;

/// Whether no light comes from it.
bool is_black(const World& world);

/// The largest optical depth, of any channel, on ways through the media towards the lights, or
/// through their middle where there are none: of a few thousand ways from the faces of their
/// bounds (metres, world). Beyond 35 it is not told apart.
double deepest_way(const Reference& reference, const Bounds& media,
                   const std::vector<Light>& lights);

/// @param depth as deepest_way()
std::vector<PlanFact> scene_facts(const Scene& scene, const medium::MediaTraits& media,
                                  double depth, const Settings& settings);

}  // namespace fumarole::study
