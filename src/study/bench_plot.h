#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "study/bench.h"

namespace fumarole::study {

/// Four plots in one picture, those that there are figures for: times of the presets, growth with
/// pixels, growth with voxels, and what each step of the ablation is worth; as a program for
/// gnuplot 5.4 that writes `png`; "" if there are none.
std::string bench_plot_program(std::span<const BenchFigure> figures, const std::string& title,
                               const std::filesystem::path& png);

/// Draws it. @returns whether there was anything to draw
/// @throws Error if gnuplot is not there or fails.
bool plot_bench(std::span<const BenchFigure> figures, const std::string& title,
                const std::filesystem::path& png);

}  // namespace fumarole::study
