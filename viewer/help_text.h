#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace fumarole::command {

/// What help, the manual and shells are told of an option, from its CLI::Option::type_name() and
/// its check(): the kind of value in capitals (`FILE.png`, `WxH`, `SECONDS`), the words that it
/// takes (`auto|y|z`), or a setting's range (`1..4096`).

/// The words that an option takes, if it takes some of a list and nothing else.
std::vector<std::string> choices_of(const CLI::Option& option);
/// As it stands behind the option; empty for a flag and for a positional, whose name says it.
std::string value_of(const CLI::Option& option);
/// What an option does, with the words that are too many to stand behind it.
std::string text_of(const CLI::Option& option);
/// `--size`, `-o` and so on; empty for a positional.
std::vector<std::string> words_of(const CLI::Option& option);

/// A text in lines of 100 columns, of which all but the first begin with `indent` spaces; the first
/// has that many taken already.
std::string wrapped(const std::string& text, std::size_t indent);

/// The help of all commands.
class HelpFormatter : public CLI::Formatter {
public:
    std::string make_help(const CLI::App* app, std::string name,
                          CLI::AppFormatMode mode) const override;
    std::string make_description(const CLI::App* app) const override;
    std::string make_subcommand(const CLI::App* command) const override;
    std::string make_option(const CLI::Option* option, bool is_positional) const override;
};

}  // namespace fumarole::command
