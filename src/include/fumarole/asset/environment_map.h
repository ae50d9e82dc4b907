#pragma once

#include <filesystem>

#include <fumarole/export.h>
#include <fumarole/scene.h>

namespace fumarole::asset {

/// Reads a latitude-longitude picture (what OpenImageIO reads; EXR and HDR are linear, 8-bit
/// pictures are taken as sRGB). NaN, infinite and negative texels become 0.
/// @throws Error naming the file: not there, unreadable, fewer than 3 channels is read as grey.
FUMAROLE_API Environment load_environment(const std::filesystem::path& file);

}  // namespace fumarole::asset
