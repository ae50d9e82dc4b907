#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "window/event.h"
#include "window/glfw_window.h"
#include "window/lettering.h"

struct ImGuiContext;

namespace fumarole::window {

/// Dear ImGui on our window, fed with our events, so that a script's are its events too.
class Gui {
public:
    explicit Gui(GlfwWindow& window);
    ~Gui();
    Gui(const Gui&) = delete;
    Gui& operator=(const Gui&) = delete;

    /// Starts a frame of the interface.
    void begin(const std::vector<Event>& events, double seconds);
    /// Draws it over what is in the window.
    void end();

    /// Whether the pointer, or the keys, are the interface's and not the picture's.
    [[nodiscard]] bool has_pointer() const;
    [[nodiscard]] bool has_keys() const;

    /// Whether the last frame had all its letters. Those of other scripts come frames later.
    [[nodiscard]] bool lettered() const { return lettering_.complete(); }
    /// What a person should know about letters, once, or "".
    std::string take_note() { return lettering_.take_note(); }

private:
    void feed(const Event& event);
    void scale_to(double content_scale);
    void update_letters();

    GlfwWindow& window_;
    ImGuiContext* context_;
    double scale_ = 0;
    glm::dvec2 pointer_{-1};
    /// Pressed and released within one frame is pressed in it, released in the next.
    bool down_[3]{}, pressed_[3]{};
    std::string clipboard_;
    Lettering lettering_;
    bool has_texture_ = false;  ///< of the letters
};

}  // namespace fumarole::window
