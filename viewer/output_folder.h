#pragma once

#include <filesystem>

namespace fumarole::command {

/// Before hours of work: makes a folder that takes files. @throws Error naming -o and the folder.
void make_folder(const std::filesystem::path& folder);

}  // namespace fumarole::command
