#include <fumarole/asset/environment_map.h>

#include <OpenImageIO/imageio.h>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <memory>

#include "asset/linear_image.h"
#include "asset/printable.h"
#include <fumarole/errors.h>

namespace fumarole::asset {

namespace {

namespace fs = std::filesystem;

// 1.5 GiB of floats; also what OpenGL drivers promise of a texture's side.
constexpr int kMaxWidth = 16384;
constexpr int kMaxHeight = 8192;

void check_size(const fs::path& file, const OIIO::ImageSpec& spec, int width, int height)
{
    if (spec.deep || spec.depth > 1)
        fail(file, "is a deep picture or a volume, expected a flat latitude-longitude picture");
    if (width < 1 || height < 1 || spec.nchannels < 1)
        fail(file, "has no pixels");
    if (std::max(width, spec.width) > kMaxWidth || std::max(height, spec.height) > kMaxHeight)
        fail(file, fmt::format("is {} x {} pixels, more than the {} x {} of an environment map: "
                               "scale it down",
                               std::max(width, spec.width), std::max(height, spec.height),
                               kMaxWidth, kMaxHeight));
}

// A file may store a part of its picture, or more than it: what it does not store is black.
std::vector<glm::vec3> placed_in_frame(const std::vector<glm::vec3>& stored,
                                       const OIIO::ImageSpec& spec, int width, int height)
{
    std::vector<glm::vec3> frame(static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
                                 glm::vec3(0));
    for (int row = 0; row < spec.height; ++row) {
        for (int column = 0; column < spec.width; ++column) {
            const std::int64_t x = std::int64_t{spec.x} - spec.full_x + column;
            const std::int64_t y = std::int64_t{spec.y} - spec.full_y + row;
            if (x >= 0 && x < width && y >= 0 && y < height)
                frame[static_cast<std::size_t>(y * width + x)] =
                    stored[static_cast<std::size_t>(std::int64_t{row} * spec.width + column)];
        }
    }
    return frame;
}

}  // namespace

Environment load_environment(const fs::path& file)
{
    check_file(file, "environment map");

    OIIO::ImageSpec hints;
    hints.attribute("oiio:UnassociatedAlpha", 1);  // colour as stored; alpha means nothing here
    const auto input = OIIO::ImageInput::open(file.string(), &hints);
    if (!input)
        fail(file, "cannot be read as a picture: " + printable(OIIO::geterror(), 200));

    const OIIO::ImageSpec& spec = input->spec();
    const int width = spec.full_width > 0 ? spec.full_width : spec.width;
    const int height = spec.full_height > 0 ? spec.full_height : spec.height;
    check_size(file, spec, width, height);

    Environment environment;
    environment.width = width;
    environment.height = height;
    std::vector<glm::vec3>& texels = environment.radiance;
    texels.resize(static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height));
    const bool grey = spec.nchannels < 3;
    if (!input->read_image(0, 0, 0, grey ? 1 : 3, OIIO::TypeFloat, texels.data(),
                           sizeof(glm::vec3)))
        fail(file, "damaged or cut short: " + printable(input->geterror(), 200));

    const bool srgb = is_srgb(spec);
    for (glm::vec3& texel : texels) {
        if (grey)
            texel = glm::vec3(texel.x);
        for (int channel = 0; channel < 3; ++channel) {
            float& value = texel[channel];
            if (!std::isfinite(value) || value < 0)
                value = 0;
            if (srgb)
                value = linear_from_srgb(value);
        }
    }
    if (spec.width != width || spec.height != height || spec.x != spec.full_x ||
        spec.y != spec.full_y)
        texels = placed_in_frame(texels, spec, width, height);
    return environment;
}

}  // namespace fumarole::asset
