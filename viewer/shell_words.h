#pragma once

#include <string>
#include <vector>

namespace fumarole::command {

/// A word as a shell takes it, quoted where it must be.
std::string shell_word(const std::string& text);

/// A command line of a program's name and its words.
std::string command_text(const std::vector<std::string>& words);

/// ` --name word`, or nothing for a word that says nothing.
std::string option_text(const char* name, const std::string& word, const std::string& usual = "");

}  // namespace fumarole::command
