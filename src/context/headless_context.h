#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "context/device_choice.h"
#include <fumarole/gl.h>

namespace fumarole::gl {

/// An OpenGL 4.5 core context without a window, for the command line and the tests. The library
/// itself never makes one.
class HeadlessContext {
public:
    /// Makes a context and makes it current on this thread.
    /// @throws Error naming what is missing, NoSuchDevice naming what there is.
    static std::unique_ptr<HeadlessContext> make(const DeviceRequest& request = {});
    static std::unique_ptr<HeadlessContext> make(Backend backend)
    {
        return make(DeviceRequest{backend});
    }

    /// All devices that EGL lists, each with a context made on it for a while.
    static std::vector<DeviceDescription> egl_devices();
    /// The same of OSMesa.
    static DeviceDescription osmesa_device();

    virtual ~HeadlessContext() = default;
    [[nodiscard]] virtual GetProc get_proc() const = 0;
    [[nodiscard]] virtual std::string_view name() const = 0;
    /// Why it is this one, and what went wrong with those that should have come first.
    [[nodiscard]] const DeviceChoice& choice() const { return choice_; }

private:
    DeviceChoice choice_;
};

}  // namespace fumarole::gl
