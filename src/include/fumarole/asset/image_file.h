#pragma once

#include <filesystem>

#include <fumarole/export.h>
#include <fumarole/scene.h>

namespace fumarole::asset {

/// Reads a picture and its alpha (what OpenImageIO reads; integers are taken as sRGB unless the
/// file says that they are linear). Without an alpha it is opaque; colour that a file does not hold
/// multiplied by alpha is multiplied. NaN, infinite and negative values become 0, and alpha ends at
/// 1.
/// @throws Error naming the file: not there, unreadable, no pixels, or too many
FUMAROLE_API TransparentImage load_image(const std::filesystem::path& file);

}  // namespace fumarole::asset
