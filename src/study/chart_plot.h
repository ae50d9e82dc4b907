#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "study/chart.h"

namespace fumarole::study {

/// 1, 2, 5 and their powers of ten within low..high, or powers of ten alone if that is many. Both
/// above 0.
std::vector<double> log_ticks(double low, double high);

/// The chart as a program for gnuplot 5.4 that writes `svg` and `png`: time across, error up, both
/// by their logarithm. @throws Error if no point can be drawn.
std::string plot_program(const Chart& chart, const std::string& title,
                         const std::filesystem::path& svg, const std::filesystem::path& png);

/// Writes both pictures. @throws Error if gnuplot is not there or fails.
void plot_chart(const Chart& chart, const std::string& title, const std::filesystem::path& svg,
                const std::filesystem::path& png);

}  // namespace fumarole::study
