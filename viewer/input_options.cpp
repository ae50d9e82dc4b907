#include "input_options.h"

#include <CLI/CLI.hpp>

namespace fumarole::command {

namespace {

void put(CLI::Option& option, const std::string& group)
{
    if (!group.empty())
        option.group(group);
}

}  // namespace

void add_size_option(CLI::App& command, std::string& size, const std::string& group)
{
    put(*command
             .add_option("--size", size,
                         "width and height of the picture in pixels [480x270, or the scene's]")
             ->type_name("WxH"),
        group);
}

void add_grid_options(CLI::App& command, std::string& grid, std::string& up,
                      const std::string& group)
{
    put(*command
             .add_option("--grid", grid,
                         "of a .vdb or .nvdb: the grid that is the medium, by its name, or name[n] "
                         "where several have it [the first fog volume]")
             ->type_name("NAME"),
        group);
    put(*command.add_option("--up", up, "of a .vdb or .nvdb: the axis that points up [auto]")
             ->check(CLI::IsMember({"auto", "y", "z"})),
        group);
}

}  // namespace fumarole::command
