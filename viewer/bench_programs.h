#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "study/bench_goals.h"
#include <fumarole/scene.h>

namespace fumarole::command {

/// Whole runs of programs on one .vdb, in turn, from start to end: `fumarole render` of the bare
/// file, with its picture written; and OpenVDB's `vdb_render` from the same camera, with shadows,
/// in steps of one voxel, through media as dense. Rows of the group `programs`.
/// @param scene shows the file's grid @param device_words of `fumarole render` @param folder holds
/// the pictures for a moment
/// @param notes what could not be run, and why
std::vector<study::BenchFigure> program_figures(const std::filesystem::path& vdb,
                                                const Scene& scene,
                                                const std::vector<std::string>& device_words,
                                                const std::filesystem::path& folder, int rounds,
                                                std::vector<std::string>& notes);

inline constexpr std::string_view kVdbRender = "vdb_render, to the file written";
inline constexpr std::string_view kVdbRenderTraces = "vdb_render, tracing alone";

}  // namespace fumarole::command
