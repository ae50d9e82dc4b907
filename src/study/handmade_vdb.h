#pragma once

#include <array>
#include <cstddef>
#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace fumarole::study {

/// 8^3 active values, x fastest, then y, then z.
struct HandmadeBrick {
    glm::ivec3 brick{0};  ///< covers the voxels 8*brick .. 8*brick + 7
    std::array<float, 512> values{};
};

/// One float grid, written without OpenVDB: so that any value, place or byte of it may be wrong.
struct HandmadeVdb {
    std::string grid_class = "fog volume";
    glm::dmat4 world_from_index{1.0};
    float background = 0;
    std::vector<HandmadeBrick> bricks;  ///< no two in one place
};

/// The bytes of a .vdb file of version 224, uncompressed.
std::string handmade_vdb(const HandmadeVdb& grid);

}  // namespace fumarole::study
