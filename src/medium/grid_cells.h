#pragma once

#include <array>
#include <cstddef>

#include "medium/grid_layout.h"
#include <fumarole/voxel_grid.h>

namespace fumarole::medium {

inline constexpr int kCellVoxels = kAtlasBrickDim * kAtlasBrickDim * kAtlasBrickDim;

/// The 9^3 values of a page: the voxels of its brick and the first layer of the next ones.
struct Cell {
    std::array<float, std::size_t{3} * kCellVoxels> values;  // x fastest, channels together
    bool uniform;                                            ///< then values[0..2] alone are set
    float max;                                               ///< over all channels
};

/// Of a uniform cell, the first values to all.
void spread(Cell& cell, int channels);

/// Where a cell's field, between its values, is not 0.
PageExtent extent_of(const Cell& cell, int channels);

/// Of the 8 bricks at page + corner_offset(0..7).
glm::ivec3 corner_offset(int corner);

void read_cell(const VoxelGrid& grid, const CellSources& sources, Cell& cell);

}  // namespace fumarole::medium
