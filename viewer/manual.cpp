// What a shell and `man` are told of the command line, from the command line itself.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <memory>
#include <string>
#include <vector>

#include "command.h"
#include "help_text.h"

namespace fumarole::command {

namespace {

std::vector<const CLI::App*> commands_of(const CLI::App& app)
{
    std::vector<const CLI::App*> commands;
    for (const CLI::App* one : app.get_subcommands({}))
        if (!one->get_group().empty())  // or it is hidden
            commands.push_back(one);
    return commands;
}

/// True if what an option takes is a file or a folder.
bool takes_file(const std::string& value)
{
    return value.starts_with("FILE") || value == "FOLDER";
}

bool is_setting(const CLI::Option& option)
{
    return option.get_group().starts_with("Settings");
}

std::string bash_completion(const CLI::App& app)
{
    const std::vector<const CLI::App*> commands = commands_of(app);
    std::vector<std::string> names;
    names.reserve(commands.size());
    for (const CLI::App* command : commands)
        names.push_back(command->get_name());
    std::string values, options;
    std::vector<std::string> others;  // a number or a name, of which a shell knows nothing
    for (const CLI::App* command : commands) {
        std::vector<std::string> all;
        for (const CLI::Option* option : command->get_options()) {
            const std::vector<std::string> words = words_of(*option);
            all.insert(all.end(), words.begin(), words.end());
            const std::string value = value_of(*option);
            if (words.empty() || value.empty())
                continue;
            std::vector<std::string> cases;
            cases.reserve(words.size());
            for (const std::string& word : words)
                cases.push_back(command->get_name() + ":" + word);
            const std::vector<std::string> choices = choices_of(*option);
            if (!choices.empty())
                values += fmt::format("    {}) words='{}' ;;\n", fmt::join(cases, "|"),
                                      fmt::join(choices, " "));
            else if (value == "FOLDER")
                values +=
                    fmt::format("    {}) COMPREPLY=($(compgen -d -- \"$current\")); return ;;\n",
                                fmt::join(cases, "|"));
            else if (!takes_file(value))
                others.insert(others.end(), cases.begin(), cases.end());
        }
        options += fmt::format("    {}) words='{}' ;;\n", command->get_name(), fmt::join(all, " "));
    }
    return fmt::format(R"(# bash completion of fumarole, written by `fumarole completion bash`
_fumarole()
{{
    local current=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD-1]}}
    local command= words= word
    for word in "${{COMP_WORDS[@]:1:COMP_CWORD-1}}"; do
        case $word in {}) command=$word; break ;; esac
    done
    case $command:$before in
{}    {}) COMPREPLY=(); return ;;
    esac
    if [[ -n $words ]]; then
        COMPREPLY=($(compgen -W "$words" -- "$current"))
        return
    fi
    case $command in
    '') words='{} --help --version --max-memory' ;;
{}    esac
    if [[ -z $command || $current == -* ]]; then
        COMPREPLY=($(compgen -W "$words" -- "$current"))
    else
        COMPREPLY=($(compgen -f -- "$current"))
    fi
}}
complete -o filenames -F _fumarole fumarole
)",
                       fmt::join(names, "|"), values, fmt::join(others, "|"), fmt::join(names, " "),
                       options);
}

/// Within single quotes and the square brackets of _arguments.
std::string zsh_text(const std::string& text)
{
    std::string quoted;
    for (const char c : text) {
        if (c == '\'')
            quoted += "'\\''";
        else if (c == '[' || c == ']' || c == ':' || c == '\\')
            quoted += std::string("\\") + c;
        else
            quoted += c;
    }
    return quoted;
}

/// What zsh is told of an option's value: the words, what kind of file, or what it is called.
std::string zsh_value(const CLI::Option& option)
{
    const std::string value = value_of(option);
    if (value.empty())
        return "";
    const std::vector<std::string> choices = choices_of(option);
    const std::string what = ":" + zsh_text(value);
    if (!choices.empty())
        return fmt::format("{}:({})", what, fmt::join(choices, " "));
    if (value == "FOLDER")
        return what + ":_files -/";
    return what + (takes_file(value) ? ":_files" : ": ");
}

std::string zsh_completion(const CLI::App& app)
{
    std::string list, cases;
    for (const CLI::App* command : commands_of(app)) {
        list +=
            fmt::format("    '{}:{}'\n", command->get_name(), zsh_text(command->get_description()));
        cases += fmt::format("  {})\n    _arguments", command->get_name());
        for (const CLI::Option* option : command->get_options())
            for (const std::string& word : words_of(*option))
                cases += fmt::format(" \\\n      '*{}[{}]{}'", word, zsh_text(text_of(*option)),
                                     zsh_value(*option));
        cases += " \\\n      '*:file:_files'\n    ;;\n";
    }
    return fmt::format(R"(#compdef fumarole
# zsh completion of fumarole, written by `fumarole completion zsh`
_fumarole() {{
  local -a commands
  commands=(
{}  )
  if (( CURRENT == 2 )); then
    _describe 'command' commands
    return
  fi
  local command=$words[2]
  shift words
  (( CURRENT-- ))
  case $command in
{}  esac
}}
_fumarole "$@"
)",
                       list, cases);
}

/// A line of roff that is text, whatever it begins with.
std::string roff(const std::string& text)
{
    std::string out;
    for (const char c : text) {
        if (c == '-')
            out += "\\-";
        else if (c == '\\')
            out += "\\e";
        else
            out += c;
    }
    if (out.starts_with('.') || out.starts_with('\''))
        out.insert(0, "\\&");
    return out;
}

std::string upper(std::string text)
{
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char c) { return char(std::toupper(c)); });
    return text;
}

std::string roff_option(const CLI::Option& option)
{
    const std::vector<std::string> words = words_of(option);
    const std::string value = value_of(option);
    const std::string head =
        words.empty()   ? fmt::format(".I {}", roff(option.get_name(true)))
        : value.empty() ? fmt::format(".B {}", roff(fmt::format("{}", fmt::join(words, ", "))))
                        : fmt::format(".BI \"{} \" \"{}\"",
                                      roff(fmt::format("{}", fmt::join(words, ", "))), roff(value));
    return fmt::format(".TP\n{}\n{}\n", head, roff(text_of(option)));
}

/// Those of a command, but for the settings, which several commands have.
std::string roff_options(const CLI::App& app)
{
    std::string text;
    for (const CLI::Option* option : app.get_options())
        if (!is_setting(*option))
            text += roff_option(*option);
    return text;
}

/// The settings once, with the commands that have them.
std::string roff_settings(const CLI::App& app)
{
    std::vector<std::string> names;
    const CLI::App* one = nullptr;
    for (const CLI::App* command : commands_of(app))
        for (const CLI::Option* option : command->get_options())
            if (is_setting(*option)) {
                names.push_back(command->get_name());
                one = command;
                break;
            }
    if (one == nullptr)
        return "";
    std::string text =
        fmt::format(".SH SETTINGS\nFurther options of {}.\n", fmt::join(names, ", "));
    std::string group;
    for (const CLI::Option* option : one->get_options()) {
        if (!is_setting(*option))
            continue;
        if (option->get_group() != group) {
            group = option->get_group();
            text += fmt::format(".SS {}\n", roff(group.substr(group.rfind(' ') + 1)));
        }
        text += roff_option(*option);
    }
    return text;
}

std::string manual(const CLI::App& app)
{
    std::string text = fmt::format(
        ".TH FUMAROLE 1 \"\" \"Fumarole {}\" \"User Commands\"\n"
        ".SH NAME\nfumarole \\- {}\n"
        ".SH SYNOPSIS\n.B fumarole\n.I command\n.RI [ options ]\n"
        ".SH OPTIONS\n{}",
        FUMAROLE_VERSION, "lit smoke, fire, cloud and fog from OpenVDB files", roff_options(app));
    for (const CLI::App* command : commands_of(app))
        text += fmt::format(".SH \"FUMAROLE {}\"\n{}.\n{}", upper(command->get_name()),
                            roff(command->get_description()), roff_options(*command));
    text += roff_settings(app);
    text +=
        ".SH EXIT STATUS\n0: all went well. 1: something in the world was wrong, a file, a disk "
        "or a device. 2: the command line was.\n"
        ".SH EXAMPLES\n.nf\nfumarole render smoke.vdb \\-o smoke.png\n"
        "fumarole view smoke.vdb\nfumarole info \\(aqsmoke_####.vdb\\(aq\n.fi\n";
    return text;
}

}  // namespace

void add_manual(CLI::App& app)
{
    CLI::App* completion =
        app.add_subcommand("completion", "What a shell completes commands with: bash or zsh");
    auto shell = std::make_shared<std::string>();
    completion->add_option("SHELL", *shell, "bash or zsh")
        ->required()
        ->check(CLI::IsMember({"bash", "zsh"}));
    completion->group("");
    completion->callback([&app, shell] {
        fmt::print("{}", *shell == "bash" ? bash_completion(app) : zsh_completion(app));
    });
    CLI::App* page = app.add_subcommand("manual", "The page for man(1)");
    page->group("");
    page->callback([&app] { fmt::print("{}", manual(app)); });
}

}  // namespace fumarole::command
