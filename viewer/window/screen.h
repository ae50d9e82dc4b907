#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "gl/device.h"
#include "window/display_pass.h"
#include "window/glfw_window.h"

namespace fumarole::window {

/// The window on the desktop with its OpenGL, and what is drawn into its framebuffer.
class Screen {
public:
    /// @param debug true keeps OpenGL's errors for check()
    /// @throws Error as GlfwWindow
    Screen(glm::ivec2 size, bool debug);
    Screen(const Screen&) = delete;
    Screen& operator=(const Screen&) = delete;

    [[nodiscard]] GlfwWindow& window() { return window_; }
    [[nodiscard]] const GlfwWindow& window() const { return window_; }
    [[nodiscard]] const gl::Device& device() const { return device_; }
    [[nodiscard]] bool software() const { return device_.capabilities().software; }

    /// Fills the framebuffer with what is behind the picture.
    void clear(glm::ivec2 pixels);
    /// Shows pictures over it; nothing before there is one.
    void show(const DisplayRequest& request);
    /// Writes what has been drawn, as it will be seen. @throws Error as write_png
    void take_screenshot(const std::string& file) const;
    /// @throws Error with the first error of OpenGL, if it keeps them
    void check() const;

private:
    GlfwWindow window_;
    gl::Device device_;
    DisplayPass display_;
    std::vector<std::string> errors_;
};

}  // namespace fumarole::window
