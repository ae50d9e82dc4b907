#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <fumarole/errors.h>

namespace fumarole::gl {

/// Where a context without a window comes from.
enum class Backend {
    automatic,  ///< a GPU through EGL where there is one that works, else osmesa
    osmesa,     ///< Mesa's software rasteriser in this process: the same everywhere, no driver
    egl,        ///< surfaceless EGL: a GPU where there is one, else its rasteriser
};

/// What a user asks for.
struct DeviceRequest {
    Backend backend = Backend::automatic;
    /// Of EGL's devices: a number from 0, or a part of a name in any case. "": the best there is.
    std::string device = {};
};

/// A device that EGL lists. Without a context little is known of it: `software`, maybe.
struct DeviceDescription {
    std::string name;       ///< GL_RENDERER
    std::string vendor;     ///< GL_VENDOR
    std::string version;    ///< GL_VERSION, which names the driver
    bool software = false;  ///< a rasteriser on the processor
    std::string refusal;    ///< why it can't be used; empty if it can
};

/// The device that was chosen, and why.
struct DeviceChoice {
    std::optional<std::size_t> egl_device;  ///< none: OSMesa
    std::string reason;                     ///< "EGL's device 1, the first GPU of 3 devices"
    /// One line for each GPU that could not be used where the rasteriser takes its place.
    std::vector<std::string> failures;
};

/// The machine has no device of this number or name: the command line is wrong.
class NoSuchDevice : public Error {
public:
    using Error::Error;
};

/// Makes a context on a device to see what it is and whether it works. It costs up to a tenth of a
/// second, so it is done of no more devices than need be.
using LookAtDevice = std::function<DeviceDescription(std::size_t)>;

/// Chooses among `software.size()` devices, of which `software[i]` tells whether EGL calls device i
/// a rasteriser.
/// @throws NoSuchDevice; Error if the device that was asked for, or all of EGL's, can't be used
DeviceChoice choose_device(const DeviceRequest& request, const std::vector<bool>& software,
                           const LookAtDevice& look);

}  // namespace fumarole::gl
