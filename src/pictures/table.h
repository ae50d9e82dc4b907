#pragma once

#include <fumarole/asset/environment_map.h>
#include <fumarole/asset/image_file.h>
#include <fumarole/write/deep_image.h>
#include <fumarole/write/image_writer.h>

#include "write/whole_picture.h"

namespace fumarole::pictures {

/// All that needs OpenImageIO.
struct Table {
    const char* version;  ///< version of the build, which must be the program's own; the first
                          ///< member in all versions
    decltype(&asset::load_image) load_image;
    decltype(&asset::load_environment) load_environment;
    decltype(&write::write_exr) write_exr;
    decltype(&write::write_deep_exr) write_deep_exr;
    decltype(&write::read_exr) read_exr;
    decltype(&write::exr_channels) exr_channels;
    decltype(&write::is_whole) is_whole;
};

/// The one function that fumarole-pictures.so shows.
using GetTable = const Table* (*)();
constexpr const char* kGetTable = "fumarole_pictures";
constexpr const char* kModule = "fumarole-pictures.so";

}  // namespace fumarole::pictures
