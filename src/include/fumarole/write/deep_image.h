#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include <glm/glm.hpp>

#include <fumarole/export.h>
#include <fumarole/write/image_writer.h>

namespace fumarole {

/// A sample of a pixel: what lies between two depths. In between it is uniform: a part of it, the
/// share f of its length, has alpha 1 - (1 - alpha)^f.
struct DeepSample {
    float front = 0;     ///< view_z [m] of its front
    float back = 0;      ///< view_z [m] of its back; equal to front for a surface or a transparent
    float alpha = 0;     ///< opacity, 0..1: the share that it hides of what is behind it
    glm::vec3 color{0};  ///< premultiplied radiance [W/m^2/sr], as if nothing lay before it
};

/// A picture of samples in depth: rows from the top, each pixel's from near to far, none within
/// another.
struct DeepImage {
    int width = 0;
    int height = 0;
    glm::ivec2 origin{0};  ///< top-left corner in the picture that it is a part of [pixels]
    glm::ivec2 whole{0};   ///< size of that picture; 0: it is no part of one
    std::vector<std::size_t> first;  ///< index of each pixel's first sample; last, their count
    std::vector<DeepSample> samples;
};

namespace write {

/// Writes R, G, B, A, Z and ZBack of a deep scanline EXR, as "Interpreting OpenEXR Deep Pixels" has
/// them; Z and ZBack keep 32 bits. Whole or not there, as write_exr.
/// @throws Error as write_exr does
FUMAROLE_API void write_deep_exr(const DeepImage& image, const std::filesystem::path& file,
                                 const ExrOptions& options = {});

}  // namespace write
}  // namespace fumarole
