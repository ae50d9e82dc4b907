#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "study/reference.h"
#include <fumarole/scene_renderer.h>
#include <fumarole/write/image_writer.h>

namespace fumarole::command {

/// One of the pictures that a render makes.
struct Target {
    std::string name;                   ///< `composite`, `depth`, ...
    std::vector<std::string> channels;  ///< their names in a file of all targets
    const std::vector<float>* pixels;   ///< channels interleaved, rows from the top, linear
};

/// All that a render made; points into what it was made of.
struct Picture {
    int width = 0, height = 0;
    glm::ivec2 whole{0}, origin{0};  ///< as in Image
    std::vector<Target> targets;     ///< the composite first, as R, G, B
    /// RGBA of the composite without what glows, or null where nothing does.
    const std::vector<float>* cover = nullptr;
};

Picture picture_of(const Still& still);
Picture picture_of(const study::ReferenceStill& still);

/// Which files are written, and how.
struct PictureFiles {
    std::vector<std::string> outputs;  ///< x.exr: linear; x.png: for a screen
    std::string target;             ///< target that is written alone as R, G, B; "" for all of them
    std::optional<float> exposure;  ///< stops of a .png, or those that suit the picture
    Display::Transform transform = Display::Transform::filmic;
    ExrOptions exr = {};
};

/// For a header: now, or what the environment's SOURCE_DATE_EPOCH says for files that are to be the
/// same each time.
std::string capture_date();

/// Of a file for a screen, by its name.
bool is_png(const std::string& output);

/// Of a file of samples in depth: x.deep.exr. write_picture() leaves those to whoever has a
/// DeepImage.
bool is_deep(const std::string& output);

/// @throws UsageError if the name given to `option` is not one of a file for a screen
void check_png(std::string_view option, const std::string& file);

/// @throws UsageError if an output's name ends in neither; Error if its folder can't be written to.
/// To be called before the work.
void check_outputs(const std::vector<std::string>& outputs);

/// Writes the files. @returns the exposure [stops] of a .png @throws Error as the writers do
float write_picture(const Picture& picture, const PictureFiles& files);

/// "wrote x.png (exposure +1.00 stops)", a line each; no exposure where a .png has none.
void print_written(const std::vector<std::string>& outputs, std::optional<float> exposure_ev);

/// Stops, or nothing for `auto`. @throws UsageError
std::optional<float> parse_exposure(const std::string& text);

/// The exposure that was asked for, or else the one that suits a target's picture (R, G, B):
/// transmittance has a white of its own.
float exposure_of(const std::string& target, const Image& image, std::optional<float> asked);

}  // namespace fumarole::command
