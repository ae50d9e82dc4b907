#pragma once

#include "context/device_choice.h"
#include <fumarole/gl.h>

namespace fumarole::gl {

/// What the current context is, and whether it works: a first dispatch must give the right numbers.
/// Never throws for what the driver does wrong: that is the description's refusal.
DeviceDescription look_at_context(GetProc get_proc);

}  // namespace fumarole::gl
