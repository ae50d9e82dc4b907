#pragma once

#include <stdexcept>
#include <string>

namespace CLI {
class App;
class Validator;
}  // namespace CLI

namespace fumarole::command {

/// The command line itself is wrong: exit code 2.
class UsageError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// For an option's check(): a number in least..most, which NaN is not.
CLI::Validator within(double least, double most);

/// Each adds its subcommand; parsing then runs it.
void add_info(CLI::App& app);
/// line: the command line, for the headers of pictures
void add_render(CLI::App& app, const std::string& line);
void add_compare(CLI::App& app);
void add_chart(CLI::App& app);
void add_plan(CLI::App& app);
void add_stability(CLI::App& app);
void add_bench(CLI::App& app);
void add_view(CLI::App& app);
/// What no one types: `thumbnail` for a file manager, `completion` and `manual` for a package. They
/// are in no help.
void add_thumbnail(CLI::App& app);
void add_manual(CLI::App& app);

}  // namespace fumarole::command
