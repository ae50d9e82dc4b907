#pragma once

#include <filesystem>
#include <span>

namespace fumarole::write {

/// Writes a file beside, then renames: it is whole or not there, and an old one stays until then.
/// @throws Error naming the file: no such folder, no right, disk full, no regular file
void write_whole(const std::filesystem::path& file, std::span<const unsigned char> bytes);

}  // namespace fumarole::write
