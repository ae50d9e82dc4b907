#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace fumarole::asset {

/// What a PLY file holds of a mesh.
struct PlyPolygons {
    std::vector<std::array<float, 6>> vertices;     ///< position, which is finite, and normal
    std::vector<std::vector<std::uint32_t>> faces;  ///< three corners or more, each of a vertex
    bool has_normals = false;
};

/// Reads a PLY file (ascii, binary of either byte order) strictly. Assimp 5.2 aborts, crashes or
/// reads for ever where one is cut short or damaged.
/// @return nothing if the bytes are no PLY
/// @throws Error saying what is wrong, without the name of the file
std::optional<PlyPolygons> read_ply(std::string_view bytes);

}  // namespace fumarole::asset
