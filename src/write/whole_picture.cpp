#include "write/whole_picture.h"

#include <system_error>
#include <vector>

#include <OpenImageIO/deepdata.h>
#include <OpenImageIO/imageio.h>

namespace fumarole::write {

bool is_whole(const std::filesystem::path& picture, glm::ivec2 size)
{
    std::error_code unknown;
    if (!std::filesystem::is_regular_file(picture, unknown))
        return false;
    const auto input = OIIO::ImageInput::open(picture.string());
    if (!input) {
        OIIO::geterror();  // or it is printed at the end
        return false;
    }
    const OIIO::ImageSpec& spec = input->spec();
    bool whole = spec.width == size.x && spec.height == size.y;
    if (whole && spec.deep) {
        OIIO::DeepData data;
        whole = input->read_native_deep_image(0, 0, data);
    } else if (whole) {
        std::vector<float> pixels(static_cast<std::size_t>(size.x) *
                                  static_cast<std::size_t>(size.y) *
                                  static_cast<std::size_t>(spec.nchannels));
        whole = input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, pixels.data());
    }
    if (!whole)
        static_cast<void>(input->geterror());
    return whole;
}

}  // namespace fumarole::write
