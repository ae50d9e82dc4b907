#include "shell_words.h"

#include <fmt/format.h>
#include <string_view>

namespace fumarole::command {

std::string shell_word(const std::string& text)
{
    constexpr std::string_view kPlain =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./=:,+@%";
    if (!text.empty() && text.find_first_not_of(kPlain) == std::string::npos)
        return text;
    std::string quoted = "'";
    for (const char c : text)
        quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return quoted + "'";
}

std::string command_text(const std::vector<std::string>& words)
{
    std::string line = "fumarole";
    for (const std::string& word : words)
        line += " " + shell_word(word);
    return line;
}

std::string option_text(const char* name, const std::string& word, const std::string& usual)
{
    return word == usual ? "" : fmt::format(" {} {}", name, shell_word(word));
}

}  // namespace fumarole::command
