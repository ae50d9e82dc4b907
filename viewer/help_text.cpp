#include "help_text.h"

#include <algorithm>
#include <cctype>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace fumarole::command {

namespace {

constexpr std::size_t kLine = 100, kIndent = 30;  // columns
/// A longer list of words stands in the text.
constexpr std::size_t kLongestValue = 44;

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

bool takes_value(const CLI::Option& option)
{
    return option.get_expected_max() > 0 && option.get_items_expected_max() > 0;
}

/// True of `blue`, false of `N`, `1..64` and `I/N`.
bool is_word(const std::string& text)
{
    return text.find("..") == std::string::npos &&
           std::none_of(text.begin(), text.end(),
                        [](unsigned char c) { return std::isupper(c) != 0; });
}

/// Without what its checks add to it: FILE of FILE:FILE, NAME of NAME:{a,b}.
std::string kind_of(const CLI::Option& option)
{
    const std::string& text = option.get_option_text();
    const std::string type = text.empty() ? option.get_type_name() : text;
    return type.substr(0, type.find(':'));
}

/// A row of two columns, the second one wrapped.
std::string row(const std::string& head, const std::string& text)
{
    std::string out = "  " + head;
    if (out.size() + 1 >= kIndent)
        out += "\n" + std::string(kIndent, ' ');
    else
        out.resize(kIndent, ' ');
    return out + wrapped(text, kIndent) + "\n";
}

/// What an option can't stand with, or can't do without.
std::string conditions_of(const CLI::Option& option)
{
    std::string text;
    const auto add = [&](const char* what, const std::set<CLI::Option*>& others) {
        if (others.empty())
            return;
        std::vector<std::string> names;
        names.reserve(others.size());
        for (const CLI::Option* one : others)
            names.push_back(one->get_name());
        std::sort(names.begin(), names.end());
        text += fmt::format(" ({} {})", what, fmt::join(names, ", "));
    };
    add("not with", option.get_excludes());
    add("needs", option.get_needs());
    return text;
}

}  // namespace

std::vector<std::string> words_of(const CLI::Option& option)
{
    std::vector<std::string> words;
    for (const std::string& name : option.get_snames())
        words.push_back("-" + name);
    for (const std::string& name : option.get_lnames())
        words.push_back("--" + name);
    return words;
}

std::vector<std::string> choices_of(const CLI::Option& option)
{
    const std::string type = option.get_type_name();
    if (const auto begin = type.find('{'); begin != std::string::npos)
        return split(type.substr(begin + 1, type.find('}') - begin - 1), ',');
    std::vector<std::string> words = split(kind_of(option), '|');
    if (words.size() < 2 || !std::all_of(words.begin(), words.end(), is_word))
        return {};
    return words;
}

std::string value_of(const CLI::Option& option)
{
    if (!takes_value(option) || words_of(option).empty())
        return "";
    const std::string list = fmt::format("{}", fmt::join(choices_of(option), "|"));
    return list.empty() || list.size() > kLongestValue ? kind_of(option) : list;
}

std::string text_of(const CLI::Option& option)
{
    std::string text = option.get_description();
    const std::vector<std::string> choices = choices_of(option);
    // Longer lists than value_of() shows, which the text may name by itself, each with its meaning.
    if (!choices.empty() && value_of(option) != fmt::format("{}", fmt::join(choices, "|")) &&
        !std::all_of(choices.begin(), choices.end(), [&](const std::string& word) {
            return text.find(word) != std::string::npos;
        })) {
        const std::size_t standard = std::min(text.rfind(" ["), text.size());
        text.insert(standard, fmt::format(": {}", fmt::join(choices, ", ")));
    }
    return text + conditions_of(option);
}

std::string wrapped(const std::string& text, std::size_t indent)
{
    std::string out;
    std::size_t column = indent;
    for (const std::string& word : split(text, ' ')) {
        if (!out.empty() && column + 1 + word.size() > kLine) {
            out += "\n" + std::string(indent, ' ');
            column = indent;
        } else if (!out.empty()) {
            out += ' ';
            ++column;
        }
        out += word;
        column += word.size();
    }
    return out;
}

std::string HelpFormatter::make_help(const CLI::App* app, std::string name,
                                     CLI::AppFormatMode mode) const
{
    // One empty line between groups, where CLI11 leaves two.
    return CLI::detail::find_and_replace(CLI::Formatter::make_help(app, std::move(name), mode),
                                         "\n\n\n", "\n\n");
}

std::string HelpFormatter::make_description(const CLI::App* app) const
{
    return wrapped(app->get_description(), 0) + "\n";
}

std::string HelpFormatter::make_subcommand(const CLI::App* command) const
{
    return row(command->get_name(), command->get_description());
}

std::string HelpFormatter::make_option(const CLI::Option* option, bool is_positional) const
{
    std::string head = is_positional ? option->get_name(true)
                                     : fmt::format("{}", fmt::join(words_of(*option), ", "));
    if (const std::string value = value_of(*option); !value.empty() && !is_positional)
        head += " " + value;
    return row(head, text_of(*option));
}

}  // namespace fumarole::command
