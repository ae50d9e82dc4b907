#pragma once

#include <string>

#include <fumarole/program_store.h>

namespace fumarole::command {

/// Compiled programs of earlier runs, in the user's cache; a store that keeps nothing after
/// keep_no_programs(), or where the user has no home.
ProgramStore kept_programs();

/// For --no-program-cache.
void keep_no_programs();

/// Where they are kept, and how many of this run's were: a line.
std::string kept_programs_text();

}  // namespace fumarole::command
