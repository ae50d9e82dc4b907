#pragma once

#include <OpenImageIO/imageio.h>
#include <cmath>
#include <string>

// What a picture file's numbers stand for. Private to src/asset, as OpenImageIO is.

namespace fumarole::asset {

/// IEC 61966-2-1
inline float linear_from_srgb(float value)
{
    return value <= 0.04045f ? value / 12.92f : std::pow((value + 0.055f) / 1.055f, 2.4f);
}

/// Integers stand for display values unless the file says otherwise.
inline bool is_srgb(const OIIO::ImageSpec& spec)
{
    const std::string space(spec.get_string_attribute("oiio:ColorSpace", ""));
    return !spec.format.is_floating_point() && !OIIO::Strutil::iequals(space, "linear");
}

}  // namespace fumarole::asset
