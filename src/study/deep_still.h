#pragma once

#include <cstdint>
#include <optional>

#include <fumarole/scene_renderer.h>
#include <fumarole/write/deep_image.h>

namespace fumarole::study {

/// The frames that a deep picture is made of.
struct DeepOptions {
    int frames = 1;  ///< as were averaged for the still
    std::uint32_t seed = 0;
    std::optional<PictureRegion> region = std::nullopt;  ///< as the still's
    /// Of merging: what two samples may differ by from one that takes their place, of transmittance
    /// and of the picture's radiance.
    float tolerance = 1e-3f;
};

/// A still's pixels taken apart along depth, by what View::volume_at() has at the depths that a
/// march keeps or where froxels' slices end. Flattened it is the still: its foreground where it has
/// one, else its composite. What is alike is merged, to less than 16 samples a pixel in the mean.
///
/// Media are samples with a front and a back, transparents samples with one depth between them; the
/// last one is the surface at the depth of the pixel's centre, or the sky at Still::kSkyDepth.
/// There is one alpha: 1 - the mean of what is let through. Radiance in front of any depth is exact
/// all the same: what a coloured medium filters of the surface is in the surface's colour, and what
/// a coloured transparent filters is in the colours of all that is behind it. Only what a
/// compositor puts between is filtered grey.
/// @param still with its layers
/// @throws Error if a transparent's factors need the colour behind it; if the picture is larger
/// than the GL draws
DeepImage deep_still(SceneRenderer& scenes, const Scene& scene, const Settings& settings,
                     const Still& still, const DeepOptions& options);

}  // namespace fumarole::study
