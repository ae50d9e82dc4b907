#pragma once

#include <string>
#include <vector>

#include "study/bench.h"

// What grids cost as they grow, and what they hold.

namespace fumarole::study {

/// Bytes that programs may still take. [/proc/meminfo: MemAvailable]
double free_memory();

/// Bytes that a grid takes on the GPU in each layout, against its active voxels and against what
/// those alone take in its file (all channels of a voxel: 2 bytes each where the file holds halves,
/// else 4), which is not the GPU's storage: rows of the group `memory`.
std::vector<BenchFigure> memory_figures(const VoxelGrid& grid, const std::string& scene);

/// One smoke cut into 64^3 voxels, 128^3, ... until a grid would need more than a quarter of the
/// memory that is free now, or the GL can't hold it, or time runs out: each made, measured in all
/// layouts and let go. What stopped it goes to `cuts`.
/// @param most_edge 0, or the largest grid's edge in voxels
std::vector<BenchFigure> sweep_grids(SceneRenderer& renderer, const BenchOptions& options,
                                     int most_edge, std::vector<std::string>& cuts);

}  // namespace fumarole::study
