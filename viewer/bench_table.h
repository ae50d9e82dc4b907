#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "study/bench_goals.h"

namespace fumarole::command {

/// All that a bench found.
struct BenchReport {
    std::string machine;            ///< a line: renderer, processor, how times were taken
    nlohmann::ordered_json device;  ///< what was drawn with, and why
    std::vector<study::BenchScene> scenes;
    std::vector<study::BenchFigure> figures;
    std::vector<study::BenchGoal> goals;
    std::vector<std::string> notes;  ///< what was cut or could not be had, and why
    std::vector<std::filesystem::path> files;
    double seconds = 0;
};

void print_bench_table(const BenchReport& report);
void print_bench_json(const BenchReport& report);

}  // namespace fumarole::command
