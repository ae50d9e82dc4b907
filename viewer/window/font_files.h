#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace fumarole::window {

/// A font file that has letters which were looked for.
struct FontFile {
    std::filesystem::path file;
    int index = 0;  ///< of the font in its file: a collection (.ttc) has several
    std::string data;
    std::set<char16_t> letters;  ///< that it has, or may have where nobody could be asked
};

/// Fonts of this computer for letters, those that have the most first; a letter that several have
/// is in the first of them alone. By fontconfig, which knows what each font has; without it, from
/// the places where Debian's packages put theirs. Takes milliseconds, or seconds where fontconfig
/// looks through the fonts for the first time.
std::vector<FontFile> find_fonts(std::set<char16_t> letters);

}  // namespace fumarole::window
