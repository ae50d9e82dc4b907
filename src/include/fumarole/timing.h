#pragma once

#include <fumarole/export.h>

namespace fumarole {

/// How the passes of a frame are timed.
enum class Timing {
    off,
    /// Timestamp queries, whose results are taken when they are there, frames later: nothing waits.
    /// On a software rasteriser (llvmpipe) they say anything.
    queries,
    /// For measuring alone: glFinish before and after each pass, on a steady clock. Waits for the
    /// GPU, so a frame takes longer; on a software rasteriser it is what can be believed.
    finish,
};

/// As tables name it.
FUMAROLE_API const char* timing_name(Timing timing);

}  // namespace fumarole
