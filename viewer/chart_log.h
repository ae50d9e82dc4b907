#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "study/chart.h"

namespace fumarole::command {

/// The visits of a sweep, a line of JSON each, so that an interrupted one goes on where it was.
/// Lines of another key (another scene, program or machine) are passed over, torn ones too.
class ChartLog {
public:
    ChartLog(std::filesystem::path file, std::string key);

    [[nodiscard]] std::vector<study::ChartVisit> read() const;

    /// Adds a line in one write. @throws Error naming the file.
    void append(const study::ChartVisit& visit);

private:
    std::filesystem::path file_;
    std::string key_;
};

}  // namespace fumarole::command
