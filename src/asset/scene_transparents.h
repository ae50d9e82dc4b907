#pragma once

#include <filesystem>
#include <string>

#include "asset/json_reader.h"
#include <fumarole/scene.h>

// A scene file's transparents.

namespace fumarole::asset {

/// @param folder that files are named from
Transparent read_transparent(JsonObject object, const std::filesystem::path& folder);

/// As read_transparent() reads it. @param place for messages: `transparents[1]`
std::string transparent_text(const Transparent& transparent, const std::string& place,
                             const std::filesystem::path& folder);

}  // namespace fumarole::asset
