#pragma once

#include <filesystem>
#include <glm/glm.hpp>
#include <vector>

#include "support/make_vdb.h"

// .nvdb files by NanoVDB's own writer, and what its own reader makes of them.

namespace fumarole::test {

/// How the values of a float grid are stored; other grids keep their type.
enum class NanoCodes { plain, fp4, fp8, fp16, fpn };
enum class NanoChecksum { none, head, all };

/// Writes all grids of a .vdb into a .nvdb.
void convert_to_nvdb(const std::filesystem::path& vdb, const std::filesystem::path& nvdb,
                     NanoCodes codes = NanoCodes::plain,
                     VdbCompression compression = VdbCompression::none,
                     NanoChecksum checksum = NanoChecksum::head);

/// What NanoVDB's own reader finds in the first grid of a file, which is of floats.
std::vector<double> nanovdb_values(const std::filesystem::path& nvdb, NanoCodes codes,
                                   const std::vector<glm::ivec3>& indices);

}  // namespace fumarole::test
