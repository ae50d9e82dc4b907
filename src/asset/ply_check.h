#pragma once

#include <optional>
#include <string>

namespace fumarole::asset {

/// Reads a PLY file (ascii, binary of either byte order) strictly and returns the same polygons as
/// a plain binary PLY: positions, normals if all are there, and faces of three corners or more.
/// Assimp 5.2 takes that well, while a PLY that is cut short or damaged makes it abort, crash or
/// read for ever.
/// @return nothing if the bytes are no PLY
/// @throws Error saying what is wrong, without the name of the file
std::optional<std::string> checked_ply(const std::string& bytes);

}  // namespace fumarole::asset
