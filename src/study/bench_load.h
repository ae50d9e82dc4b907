#pragma once

#include <filesystem>
#include <vector>

#include "gl/device.h"
#include "study/bench.h"

namespace fumarole::study {

/// How long a .vdb takes from the disk to its first frame, stage by stage, on a renderer of its own
/// each round: rows of the group `load`. Every stage is timed from outside, by calling what does
/// it: where that does more, the time of the rest is taken off.
///
/// Not told apart: uploading a grid from making its uniform blocks and shadow map, and compiling
/// shaders from drawing the first frame (a later frame's time is taken off). Files come from the
/// system's cache after the first round, and shaders from the driver's, where it has one.
/// @throws Error as the readers do
std::vector<BenchFigure> load_figures(const std::filesystem::path& vdb, gl::GetProc get_proc,
                                      int rounds);

}  // namespace fumarole::study
