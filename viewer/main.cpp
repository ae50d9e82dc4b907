#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <iostream>
#include <string>
#include <vector>

#include "asset/printable.h"
#include "command.h"
#include "help_text.h"
#include "kept_programs.h"
#include "machine.h"
#include "pictures/ahead.h"
#include "settings_input.h"
#include "shell_words.h"
#include "study/flag_names.h"
#include <fumarole/asset/load_limits.h>
#include <fumarole/errors.h>

namespace {

/// In one line, whatever the names of files and grids in it hold, and in the command line's words.
std::string one_line(const char* message)
{
    return fumarole::asset::printable(fumarole::study::with_flags(message), std::string::npos);
}

/// What CLI11 refuses, as we say it. A shell makes many words of an unquoted smoke_*.vdb.
std::string usage_message(const CLI::App* app, const CLI::Error& error)
{
    std::string asked = app->get_name();
    for (const CLI::App* command : app->get_subcommands())
        asked += " " + command->get_name();
    const bool many = dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr;
    return fmt::format("fumarole: {}; {}{} --help tells more\n", one_line(error.what()),
                       many ? "one input at a time: a sequence is named in quotes, e.g. "
                              "'smoke_####.vdb'; "
                            : "",
                       asked);
}

/// Letters to be added, dropped, replaced or swapped with the next until one word is the other
/// (Damerau's distance, in the form called optimal string alignment).
std::size_t distance(const std::string& a, const std::string& b)
{
    std::vector<std::vector<std::size_t>> to(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
    for (std::size_t i = 0; i <= a.size(); ++i)
        for (std::size_t j = 0; j <= b.size(); ++j) {
            if (i == 0 || j == 0) {
                to[i][j] = i + j;
                continue;
            }
            const std::size_t replaced = to[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
            to[i][j] = std::min({to[i - 1][j] + 1, to[i][j - 1] + 1, replaced});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                to[i][j] = std::min(to[i][j], to[i - 2][j - 2] + 1);
        }
    return to[a.size()][b.size()];
}

/// The likeliest of some words, or "" if none is likely.
std::string nearest(const std::string& word, const std::vector<std::string>& words)
{
    std::string found;
    std::size_t least = 1 + word.size() / 3;
    for (const std::string& other : words)
        if (const std::size_t d = distance(word, other);
            d <= least && (found.empty() || d < least)) {
            found = other;
            least = d;
        }
    return found;
}

/// A mistyped command or option is answered with the one that was meant.
void check_words(const CLI::App& app, const std::vector<std::string>& words)
{
    using fumarole::command::UsageError;
    if (words.empty() || words.front().empty() || words.front().front() == '-')
        return;
    const std::string& asked = words.front();
    std::vector<std::string> commands;
    const CLI::App* command = nullptr;
    for (const CLI::App* one : app.get_subcommands({})) {
        if (!one->get_group().empty())  // or it is hidden
            commands.push_back(one->get_name());
        if (one->get_name() == asked)
            command = one;
    }
    if (command == nullptr) {
        const std::string meant = nearest(asked, commands);
        std::error_code unknown;
        throw UsageError(
            fmt::format("no command '{}'; {}", asked,
                        !meant.empty() ? fmt::format("did you mean '{}'?", meant)
                        : std::filesystem::exists(asked, unknown)
                            ? fmt::format("to see a file: fumarole view {}", asked)
                            : fmt::format("commands are {}", fmt::join(commands, ", "))));
    }
    for (const std::string& word : words) {
        if (word == "--")
            break;
        if (!word.starts_with("--") || word.size() < 4)
            continue;
        const std::string option = word.substr(0, word.find('='));
        if (command->get_option_no_throw(option) != nullptr ||
            app.get_option_no_throw(option) != nullptr)
            continue;
        std::vector<std::string> options;
        for (const CLI::Option* one : command->get_options())
            for (const std::string& name : one->get_lnames())
                options.push_back("--" + name);
        if (const std::string meant = nearest(option, options); !meant.empty())
            throw UsageError(
                fmt::format("{} has no option {}; did you mean {}?", asked, option, meant));
    }
}

}  // namespace

int main(int argc, char** argv)
{
    namespace command = fumarole::command;
    // A file over its limit (ulimit -f) is an error like a full disk, and no end of the process.
    std::signal(SIGXFSZ, SIG_IGN);
    command::keep_freed_memory();
    const fumarole::pictures::AtEnd pictures;
    const std::vector<std::string> words = command::with_present_names({argv + 1, argv + argc});
    CLI::App app{"Fumarole: lit smoke, fire, cloud and fog from OpenVDB files, on OpenGL"};
    app.name("fumarole");
    app.formatter(std::make_shared<command::HelpFormatter>());  // of the subcommands, too
    app.set_version_flag("--version", FUMAROLE_VERSION);
    app.require_subcommand(1);
    app.fallthrough();
    app.add_option_function<std::uint64_t>(
           "--max-memory",
           [](const std::uint64_t& bytes) { fumarole::asset::set_memory_limit(bytes); },
           "the most memory that reading a file may take, e.g. 2G [three quarters of the "
           "machine's]")
        ->transform(CLI::AsSizeValue(false))
        ->option_text("SIZE");
    app.add_flag_callback("--no-program-cache", command::keep_no_programs,
                          "compile all shaders anew, and keep none in $XDG_CACHE_HOME/fumarole");
    app.failure_message(usage_message);
    command::add_info(app);
    command::add_render(app, command::command_text(words));
    command::add_compare(app);
    command::add_chart(app);
    command::add_plan(app);
    command::add_stability(app);
    command::add_bench(app);
    command::add_view(app);
    command::add_thumbnail(app);
    command::add_manual(app);
    // After the subcommands, which would take it for their own.
    app.footer("To begin:\n"
               "  fumarole render smoke.vdb    a picture, smoke.png\n"
               "  fumarole view smoke.vdb      a window\n"
               "fumarole SUBCOMMAND --help tells what each takes.");
    try {
        check_words(app, words);
        try {
            // CLI11 takes the last word first.
            app.parse(std::vector<std::string>(words.rbegin(), words.rend()));
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
