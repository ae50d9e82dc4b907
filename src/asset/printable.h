#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace fumarole::asset {

/// A name or message from a file, made fit for one line of ours: control characters escaped, long
/// text cut at a whole UTF-8 character.
std::string printable(std::string_view text, std::size_t max_bytes = 80);

/// @throws Error of one line: the file, and what is wrong with it
[[noreturn]] void fail(const std::filesystem::path& file, const std::string& problem);

/// @param what the file should be: `file`, `picture`, ...
/// @throws Error if it is not there, is a folder, a device or a pipe, or can't be opened
void check_file(const std::filesystem::path& file, std::string_view what);

}  // namespace fumarole::asset
