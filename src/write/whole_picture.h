#pragma once

#include <filesystem>
#include <glm/glm.hpp>

namespace fumarole::write {

/// Whether a picture is there, of that size, and can be read to its last pixel.
bool is_whole(const std::filesystem::path& picture, glm::ivec2 size);

}  // namespace fumarole::write
