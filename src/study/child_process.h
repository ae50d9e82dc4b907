#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace fumarole::study {

/// What became of another program.
struct ChildResult {
    bool found = true;      ///< false: no program of that name; nothing ran
    int code = -1;          ///< exit code, or 128 + the signal that ended it
    double seconds = 0;     ///< seconds from its start to its end
    std::string said = {};  ///< on both its outputs
};

struct ChildOptions {
    int nice = 0;                      ///< how much others go before it
    std::function<bool()> stops = {};  ///< asked again and again while it runs: true ends it
};

/// Runs a program, found as a shell finds it, with nothing on its input, and waits for its end.
/// @param log a file for what it says; gone afterwards
/// @throws Error if it is there and can't be started.
ChildResult run_child(std::vector<std::string> arguments, const std::filesystem::path& log,
                      const ChildOptions& options = {});

}  // namespace fumarole::study
