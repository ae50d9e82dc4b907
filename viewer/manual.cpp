// What a shell and `man` are told of the command line, from the command line itself.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <memory>
#include <string>
#include <vector>

#include "command.h"
#include <fumarole/settings.h>

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

/// `--size`, `-o` and so on of an option; empty for a positional.
std::vector<std::string> words_of(const CLI::Option& option)
{
    std::vector<std::string> words;
    for (const std::string& name : option.get_snames())
        words.push_back("-" + name);
    for (const std::string& name : option.get_lnames())
        words.push_back("--" + name);
    return words;
}

std::vector<std::string> split(std::string text, char by)
{
    std::vector<std::string> parts;
    for (std::size_t end = 0; end != std::string::npos;) {
        end = text.find(by);
        parts.push_back(text.substr(0, end));
        if (end != std::string::npos)
            text.erase(0, end + 1);
    }
    return parts;
}

/// The words that an option takes, where it takes some of a list: TEXT:{a,b}, or a setting's a|b.
std::vector<std::string> choices_of(const CLI::Option& option)
{
    const std::string type = option.get_type_name();
    if (const auto begin = type.find('{'); begin != std::string::npos)
        return split(type.substr(begin + 1, type.find('}') - begin - 1), ',');
    for (const SettingInfo& info : setting_table())
        if (option.check_lname(std::string(info.name)) &&
            info.values.find('|') != std::string_view::npos &&
            info.values.find("..") == std::string_view::npos)
            return split(std::string(info.values), '|');
    return {};
}

bool takes_value(const CLI::Option& option)
{
    return option.get_expected_max() > 0 && option.get_items_expected_max() > 0;
}

std::string bash_completion(const CLI::App& app)
{
    const std::vector<const CLI::App*> commands = commands_of(app);
    std::vector<std::string> names;
    names.reserve(commands.size());
    for (const CLI::App* command : commands)
        names.push_back(command->get_name());
    std::string values, options;
    for (const CLI::App* command : commands) {
        std::vector<std::string> all;
        for (const CLI::Option* option : command->get_options()) {
            const std::vector<std::string> words = words_of(*option);
            all.insert(all.end(), words.begin(), words.end());
            const std::vector<std::string> choices = choices_of(*option);
            if (choices.empty() || words.empty())
                continue;
            std::vector<std::string> cases;
            cases.reserve(words.size());
            for (const std::string& word : words)
                cases.push_back(command->get_name() + ":" + word);
            values += fmt::format("    {}) words='{}' ;;\n", fmt::join(cases, "|"),
                                  fmt::join(choices, " "));
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
{}    esac
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
                       fmt::join(names, "|"), values, fmt::join(names, " "), options);
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

std::string zsh_completion(const CLI::App& app)
{
    std::string list, cases;
    for (const CLI::App* command : commands_of(app)) {
        list +=
            fmt::format("    '{}:{}'\n", command->get_name(), zsh_text(command->get_description()));
        cases += fmt::format("  {})\n    _arguments", command->get_name());
        for (const CLI::Option* option : command->get_options())
            for (const std::string& word : words_of(*option)) {
                const std::vector<std::string> choices = choices_of(*option);
                cases += fmt::format(
                    " \\\n      '*{}[{}]{}'", word, zsh_text(option->get_description()),
                    !takes_value(*option) ? ""
                    : choices.empty()     ? ":value:_files"
                                          : fmt::format(":value:({})", fmt::join(choices, " ")));
            }
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

std::string roff_options(const CLI::App& app)
{
    std::string text;
    for (const CLI::Option* option : app.get_options()) {
        const std::vector<std::string> words = words_of(*option);
        std::string head =
            words.empty() ? option->get_name(true) : fmt::format("{}", fmt::join(words, ", "));
        if (!words.empty() && takes_value(*option)) {
            const std::vector<std::string> choices = choices_of(*option);
            const std::string type = option->get_type_name();
            head += choices.empty() ? " " + type.substr(0, type.find_first_of(": "))
                                    : fmt::format(" {}", fmt::join(choices, "|"));
        }
        text += fmt::format(".TP\n.B {}\n{}\n", roff(head), roff(option->get_description()));
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
        text += fmt::format(
            ".SH \"FUMAROLE {}\"\n{}.\n{}",
            [&] {
                std::string name = command->get_name();
                std::transform(name.begin(), name.end(), name.begin(),
                               [](unsigned char c) { return char(std::toupper(c)); });
                return name;
            }(),
            roff(command->get_description()), roff_options(*command));
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
