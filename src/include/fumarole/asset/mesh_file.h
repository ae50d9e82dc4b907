#pragma once

#include <filesystem>

#include <fumarole/export.h>
#include <fumarole/scene.h>

namespace fumarole::asset {

/// Reads every triangle of a mesh file (what Assimp reads: glTF, OBJ, PLY, STL, ...), node
/// transforms applied, polygons triangulated, strips and fans unrolled, points and lines left out,
/// missing normals made. Coordinates stay as the file has them: no axis is swapped. Of a glTF file
/// that has materials the factors of the one with the largest area are read too, and no texture.
/// @throws Error naming the file: not there, unreadable, unsupported compression, no triangle, NaN.
FUMAROLE_API Mesh load_mesh(const std::filesystem::path& file);

}  // namespace fumarole::asset
