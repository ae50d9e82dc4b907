#pragma once

#include <fumarole/log.h>

namespace fumarole::command {

/// Tells on stderr what the library says as it draws, in the words of the command line: each line
/// once a process, as whoever tries many settings hears the same of each. For any thread.
Log library_log();

}  // namespace fumarole::command
