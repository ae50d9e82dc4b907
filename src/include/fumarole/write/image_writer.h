#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include <fumarole/export.h>

namespace fumarole {

/// A picture in memory: rows from the top, linear, channels interleaved.
struct Image {
    int width = 0;
    int height = 0;
    std::vector<std::string> channels;  ///< names: `R`, `G`, `B`, `scattering.R`, ...
    std::vector<float> pixels;          ///< values, width * height * channels.size() of them
    /// Of a part of a larger picture: that one's size, and where the part begins in it, in pixels
    /// from the top left. 0: the picture is whole.
    glm::ivec2 whole{0}, origin{0};

    [[nodiscard]] float at(int x, int y, int channel) const
    {
        return pixels[(static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                       static_cast<std::size_t>(x)) *
                          channels.size() +
                      static_cast<std::size_t>(channel)];
    }
};

/// How linear radiance becomes a picture for a screen.
struct Display {
    float exposure_ev = 0;  ///< exposure [stops]: radiance is multiplied by 2^exposure_ev
    enum class Transform { filmic, srgb } transform = Transform::filmic;
};

/// How an EXR is stored, and what its header says of its making; "" leaves an entry out.
struct ExrOptions {
    /// 16-bit floats, cut off at 65504; what is named depth keeps 32 bits.
    bool half = false;
    std::string captured = "";          ///< capDate, local time: `2026:11:28 02:40:00`
    std::string software = "Fumarole";  ///< program with its version
    std::string command = "";           ///< `commandLine`, the line that made the picture
};

namespace write {

/// Writes linear floats (zip) with their channel names, beside, then renames: a file is whole or
/// not there, and an old one stays until the new one is whole (a link is replaced, not followed).
/// Same picture and options in, same bytes out. Channels come back in any order: read by name. A
/// part of a picture is a data window within the display window of the whole.
/// @throws Error naming the file: no such folder, no right, disk full, NaN or infinity in the
/// picture (with channel and pixel), a channel name used twice.
FUMAROLE_API void write_exr(const Image& image, const std::filesystem::path& file,
                            const ExrOptions& options = {});

/// Writes R, G, B (and A if there) as 8-bit sRGB PNG through a display transform, with 1/255 of
/// fixed-pattern dither left out: same picture in, same bytes out. RGB is taken as premultiplied by
/// A and divided by it before the transform; where A is 0 it is stored as it is, under alpha 0. If
/// there are cover.R, cover.G and cover.B, the light of what A counts, then the rest glows, and A
/// is raised to the brightest channel that a screen needs for it. Whole or not there. @throws Error
/// as write_exr, and if R, G or B is missing; other channels are ignored and may be NaN.
FUMAROLE_API void write_png(const Image& image, const Display& display,
                            const std::filesystem::path& file);

/// Reads channels by name from an EXR's first part (`R`, `scattering.R`, ...), in the order asked;
/// all of them, in the file's order, if none is named. @throws Error naming file and channel: not
/// there, integers, a deep picture, one that reaches out of its display window, a torn file.
FUMAROLE_API Image read_exr(const std::filesystem::path& file,
                            const std::vector<std::string>& channels);
FUMAROLE_API std::vector<std::string> exr_channels(const std::filesystem::path& file);

/// Stops that bring the picture's bright parts to a screen's white, or its average to middle grey
/// if that takes fewer: from a high percentile and the log-average of R, G, B luminance. A few huge
/// pixels and any amount of black leave it alone; NaN counts as black. 0 for a black picture.
/// @throws Error if R, G or B is missing.
FUMAROLE_API float auto_exposure(const Image& image);

/// One RGB of linear radiance to display-encoded 0..1; 18 % grey at exposure 0 gives 0.46 in both
/// transforms.
FUMAROLE_API glm::vec3 display_transform(glm::vec3 radiance, const Display& display);

}  // namespace write
}  // namespace fumarole
