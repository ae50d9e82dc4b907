#pragma once

#include <string>

namespace fumarole::command {

/// What a figure was measured on: `Intel Xeon ..., 2 cores`; `Linux 6.1, x86_64`.
std::string processor_name();
std::string system_name();

/// Has memory that is freed stay the process's, up to a bound. A software rasteriser's textures
/// come and go with each frame of a sequence, and pages that are handed back are cleared when they
/// come anew: a twentieth of a frame's time.
void keep_freed_memory();

}  // namespace fumarole::command
