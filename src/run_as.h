#pragma once

#include <fumarole/settings.h>

#include "gl/device.h"

namespace fumarole {

/// Whether a device runs the passes of a frame as compute shaders.
inline bool runs_compute(const gl::Device& device, const FrameSettings& settings)
{
    using Passes = FrameSettings::Passes;
    return settings.passes == Passes::compute ||
           (settings.passes == Passes::automatic && !device.capabilities().software);
}

}  // namespace fumarole
