#pragma once

#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "gl/device.h"
#include "window/event.h"

struct GLFWwindow;
struct GLFWcursor;

namespace fumarole::window {

/// The size that becomes `size` once it is multiplied by how much larger text is on a screen, where
/// a unit is a dot of the framebuffer; where the system scales units itself it is `size`. What a
/// screen of any scale is given is got back, though fractions of a unit are cut off.
glm::ivec2 unscaled(glm::ivec2 size, glm::ivec2 pixels, double content_scale);

/// A window with an OpenGL 4.5 core context, current while it lives. One at a time.
class GlfwWindow {
public:
    /// @param size of the window, in its own units
    /// @throws Error if there is no display, or its OpenGL is older than 4.5, saying what to do.
    GlfwWindow(glm::ivec2 size, bool debug_context);
    ~GlfwWindow();
    GlfwWindow(const GlfwWindow&) = delete;
    GlfwWindow& operator=(const GlfwWindow&) = delete;

    /// What has come in since the last call; waits for something to, for `seconds` at most.
    std::vector<Event> poll(double seconds);
    /// Ends a poll() that waits; from any thread.
    static void wake();
    void swap();

    [[nodiscard]] bool closing() const;
    void close();
    [[nodiscard]] bool minimised() const;
    void minimise(bool on);
    void resize(glm::ivec2 size);
    void set_title(const std::string& title);
    void set_clipboard(const std::string& text);
    [[nodiscard]] std::string clipboard() const;
    /// 0 an arrow, 1 a bar for text, 2 a double arrow from left to right, 3 a hand.
    void set_cursor(int shape);

    [[nodiscard]] glm::ivec2 size() const;    ///< size in its own units
    [[nodiscard]] glm::ivec2 pixels() const;  ///< size of its framebuffer
    /// What the constructor is to be given for a window of this size: it makes it larger on a
    /// screen of more dots an inch, where units are dots.
    [[nodiscard]] glm::ivec2 unscaled_size() const;
    /// How much larger text is to be than on a screen of 96 dots an inch.
    [[nodiscard]] double content_scale() const;
    [[nodiscard]] static gl::GetProc get_proc();

private:
    GLFWwindow* window_ = nullptr;
    std::vector<GLFWcursor*> cursors_;
    int cursor_ = 0;
    std::vector<Event> events_;
};

}  // namespace fumarole::window
