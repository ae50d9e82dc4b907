#pragma once

#include <optional>
#include <string>

#include "bounce_count.h"
#include "device_options.h"
#include "scene_input.h"
#include "study/reference.h"

namespace fumarole::command {

/// One scene, several ways to render it.
struct ModesOptions {
    SceneInput scene{.file = "", .size = "", .grid = "", .up = "auto"};
    std::string modes = "raymarch,froxel";  ///< modes, presets, `reference`
    std::string output;                     ///< x.png with all pictures, or ""
    std::string exposure = "auto";
    DeviceOptions device;
    int aa = 1;
    int frames = 16;                  ///< timed; froxels gather over them
    std::optional<double> tolerance;  ///< tolerance of the reference; else study::usual_tolerance()
    std::string bounces =
        "all";  ///< bounces of the reference, or 0: light scatters once in the modes too
    /// Of the reference.
    std::string surface_bounces = "auto";
    bool no_reference = false, json = false;
};

/// Renders them and the reference, and says how far each is from it and from the others.
/// @throws UsageError if the words don't fit; Error as the renderers and writers do.
void compare_modes(const ModesOptions& options);

}  // namespace fumarole::command
