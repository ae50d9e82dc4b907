#include <fumarole/asset/image_file.h>

#include <OpenImageIO/imageio.h>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "asset/linear_image.h"
#include "asset/printable.h"
#include <fumarole/errors.h>

namespace fumarole::asset {

namespace {

namespace fs = std::filesystem;

constexpr int kMaxSide = 8192;  ///< 1 GiB of floats

float held(float value)
{
    return std::isfinite(value) && value > 0 ? value : 0.0f;
}

}  // namespace

TransparentImage load_image(const fs::path& file)
{
    check_file(file, "picture");
    // As it is in the file: what is display-encoded becomes linear before alpha multiplies it.
    OIIO::ImageSpec hints;
    hints.attribute("oiio:UnassociatedAlpha", 1);
    const auto input = OIIO::ImageInput::open(file.string(), &hints);
    if (!input)
        fail(file, "cannot be read as a picture: " + printable(OIIO::geterror(), 200));
    const OIIO::ImageSpec& spec = input->spec();
    if (spec.deep || spec.depth > 1)
        fail(file, "is a deep picture or a volume, expected a flat picture");
    if (spec.width < 1 || spec.height < 1 || spec.nchannels < 1)
        fail(file, "has no pixels");
    if (std::max(spec.width, spec.height) > kMaxSide)
        fail(file, fmt::format("is {} x {} pixels, more than {} a side: scale it down", spec.width,
                               spec.height, kMaxSide));

    const int channels = spec.nchannels;
    const bool grey = channels < 3;
    const int alpha = spec.alpha_channel >= 0 ? spec.alpha_channel
                      : channels == 2         ? 1
                      : channels == 4         ? 3
                                              : -1;
    const auto pixels =
        static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height);
    std::vector<float> values(pixels * static_cast<std::size_t>(channels));
    if (!input->read_image(0, 0, 0, channels, OIIO::TypeFloat, values.data()))
        fail(file, "damaged or cut short: " + printable(input->geterror(), 200));

    // A file whose colour is multiplied already says nothing here: it is what readers give.
    const bool associated = spec.get_int_attribute("oiio:UnassociatedAlpha", 0) == 0;
    const bool srgb = is_srgb(spec);
    TransparentImage image;
    image.width = spec.width;
    image.height = spec.height;
    image.texels.reserve(pixels);
    for (std::size_t i = 0; i < pixels; ++i) {
        const float* texel = &values[i * static_cast<std::size_t>(channels)];
        const float a = alpha >= 0 ? std::min(held(texel[alpha]), 1.0f) : 1.0f;
        glm::vec4 out(0, 0, 0, a);
        for (int c = 0; c < 3; ++c) {
            float value = held(texel[grey ? 0 : c]);
            if (srgb)
                value = linear_from_srgb(value);
            out[c] = associated ? value : value * a;
        }
        image.texels.push_back(out);
    }
    return image;
}

}  // namespace fumarole::asset
