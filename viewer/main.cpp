#include <cstdio>
#include <exception>
#include <fmt/format.h>
#include <iostream>

#include "asset/printable.h"
#include "command.h"
#include "study/flag_names.h"
#include <fumarole/errors.h>

namespace {

/// In one line, whatever the names of files and grids in it hold, and in the command line's words.
std::string one_line(const char* message)
{
    return fumarole::asset::printable(fumarole::study::with_flags(message), std::string::npos);
}

std::string usage_message(const CLI::App* app, const CLI::Error& error)
{
    return CLI::FailureMessage::simple(
        app, CLI::Error(error.get_name(), one_line(error.what()), error.get_exit_code()));
}

}  // namespace

int main(int argc, char** argv)
{
    namespace command = fumarole::command;
    CLI::App app{"Fumarole: lit smoke, fire, cloud and fog from OpenVDB files, on OpenGL"};
    app.name("fumarole");
    app.set_version_flag("--version", FUMAROLE_VERSION);
    app.require_subcommand(1);
    app.failure_message(usage_message);
    command::add_info(app);
    command::add_render(app);
    command::add_compare(app);
    command::add_chart(app);
    command::add_plan(app);
    command::add_stability(app);
    command::add_bench(app);
    command::add_view(app);
    try {
        try {
            app.parse(argc, argv);
        } catch (const CLI::ParseError& error) {  // --help and --version too
            if (app.exit(error) != 0)
                return 2;
        }
        // A full disk behind a redirection shows only now.
        std::cout.flush();
        if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0 || !std::cout)
            throw fumarole::Error("standard output: can't be written; is the disk full?");
        return 0;
    } catch (const command::UsageError& error) {
        fmt::print(stderr, "fumarole: {}\n", one_line(error.what()));
        return 2;
    } catch (const std::bad_alloc&) {
        fmt::print(stderr, "fumarole: out of memory; try a smaller --size or grid\n");
        return 1;
    } catch (const std::exception& error) {
        fmt::print(stderr, "fumarole: {}\n", one_line(error.what()));
        return 1;
    }
}
