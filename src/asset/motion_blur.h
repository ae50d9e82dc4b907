#pragma once

#include <filesystem>
#include <glm/glm.hpp>

#include <fumarole/voxel_grid.h>

namespace fumarole::asset {

/// What of a grid's values stays as it is while they move.
enum class Kept {
    sum,    ///< densities and emission: what leaves one voxel arrives in others
    fourth  ///< temperatures: the sum of their fourth powers, which is what they radiate
};

/// How far a medium moves while the shutter is open: a grid of three signed numbers a voxel, times
/// a matrix that makes of them metres of the file.
struct Displacement {
    const VoxelGrid* velocity;
    glm::dmat3 world_from_value;
};

/// The mean of `grid` while it moves, the shutter's middle at the grid's own time. Every voxel goes
/// straight along its displacement and is spread over the voxels that it passes.
/// @throws Error naming `file` if a voxel passes more than 256 others, which a wrong unit does
VoxelGrid moved_grid(const VoxelGrid& grid, const Displacement& displacement, Kept kept,
                     const std::filesystem::path& file);

/// The mean of a color grid, each voxel counted by the density that is at its place, so that smoke
/// takes its color along.
VoxelGrid moved_color(const VoxelGrid& color, const VoxelGrid& density,
                      const Displacement& displacement, const std::filesystem::path& file);

}  // namespace fumarole::asset
