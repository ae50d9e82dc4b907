#pragma once

#include <string>

namespace fumarole::command {

/// A word as a shell takes it, quoted where it must be.
std::string shell_word(const std::string& text);

/// ` --name word`, or nothing for a word that says nothing.
std::string option_text(const char* name, const std::string& word, const std::string& usual = "");

}  // namespace fumarole::command
