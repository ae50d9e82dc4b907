#pragma once

#include <memory>
#include <string_view>

#include <fumarole/gl.h>

namespace fumarole::gl {

/// An OpenGL 4.5 core context without a window, for the command line and the tests. The library
/// itself never makes one.
class HeadlessContext {
public:
    enum class Backend {
        osmesa,  ///< Mesa's software rasteriser in this process: the same everywhere, no driver
        egl,     ///< surfaceless EGL: a GPU where there is one
    };

    /// Makes a context and makes it current on this thread.
    /// @throws Error naming what is missing.
    static std::unique_ptr<HeadlessContext> make(Backend backend);

    virtual ~HeadlessContext() = default;
    [[nodiscard]] virtual GetProc get_proc() const = 0;
    [[nodiscard]] virtual std::string_view name() const = 0;
};

}  // namespace fumarole::gl
