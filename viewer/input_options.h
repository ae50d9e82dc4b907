#pragma once

#include <string>

namespace CLI {
class App;
}

namespace fumarole::command {

/// `--size` of the picture that a command renders.
void add_size_option(CLI::App& command, std::string& size, const std::string& group = "");
/// `--grid` and `--up`, of a bare .vdb or .nvdb.
void add_grid_options(CLI::App& command, std::string& grid, std::string& up,
                      const std::string& group = "");

}  // namespace fumarole::command
