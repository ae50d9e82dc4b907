#pragma once

#include <string>

namespace fumarole::command {

/// What a figure was measured on: `Intel Xeon ..., 2 cores`; `Linux 6.1, x86_64`.
std::string processor_name();
std::string system_name();

}  // namespace fumarole::command
