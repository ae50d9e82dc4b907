#pragma once

#include <span>
#include <string>
#include <string_view>

#include <fumarole/export.h>

namespace fumarole {

/// What of a frame is shown instead of its picture, and where: Renderer::inspect draws it.
struct Inspection {
    enum class Kind {
        scattering,     ///< radiance that the media send to the eye [W/m^2/sr], as it is
        transmittance,  ///< what they let through of the scene, 0..1 per channel, as it is
        depth,          ///< view depth of the scene's surfaces [m]
        samples,        ///< evaluations of the media that a pixel's ray, or its column of froxels,
                        ///< takes, shadows included
        density_slice,  ///< extinction, the mean of its channels, on a plane through the media
                        ///< [1/m]
        froxel_slice,   ///< radiance that the froxels of one slice add along a metre of ray, the
                        ///< mean of its channels [W/m^2/sr/m]
        bricks,         ///< boxes of what is kept of the media, by the largest extinction in each
                        ///< [1/m]
        layers,         ///< transparent fragments of a pixel, one behind the other
        probe,  ///< what a probe has seen, all around and by roughness, and the light of its
                ///< harmonics on a matt ball [W/m^2/sr], as it is
    };
    Kind kind = Kind::transmittance;
    int probe = 0;          ///< probe: of Scene::probes, or 0 for one that was placed by itself
    int axis = 2;           ///< density_slice: of the world, 0 x, 1 y, 2 z
    double position = 0.5;  ///< density_slice: 0..1 of the media's bounds along the axis;
                            ///< froxel_slice: 0..1 of the slices, near to far
    double scale = 0;       ///< the value at the end of the colour scale; 0: one that suits what is
                            ///< there. Not of scattering, transmittance
                            ///< and probes.

    bool operator==(const Inspection&) const = default;
};

/// What the colours mean. False colours are those of study::difference_color(t, magnitude), t = 0
/// at `low` and 1 at `high`; what is beyond has the end's colour.
struct InspectionLegend {
    double low = 0, high = 1;
    std::string unit;     ///< "1/m", ..., or ""
    std::string caption;  ///< what is shown, in a few words
    /// Else the colours are the values, and low and high mean nothing for scattering.
    bool false_color = true;
};

struct InspectionInfo {
    Inspection::Kind kind;
    std::string_view name;  ///< as the command line spells it: `samples`, `density-slice`
    std::string_view help;  ///< a few words
};

/// All kinds, in the order of Inspection::Kind.
FUMAROLE_API std::span<const InspectionInfo> inspection_table();

FUMAROLE_API std::string_view inspection_name(Inspection::Kind kind);
/// @throws Error listing the names if there is no such kind.
FUMAROLE_API Inspection::Kind find_inspection(std::string_view name);

}  // namespace fumarole
