#pragma once

#include <glm/glm.hpp>
#include <string>
#include <variant>
#include <vector>

// What comes in from a person, or from a script in a person's stead. Places are in the window's own
// units from its top left; keys are GLFW's.

namespace fumarole::window {

struct Modifiers {
    bool shift = false, control = false, alt = false;

    bool operator==(const Modifiers&) const = default;
};

struct KeyEvent {
    int key = 0;
    bool down = true;
    Modifiers modifiers = {};
};

struct TextEvent {
    unsigned codepoint = 0;
};

struct PointerMoved {
    glm::dvec2 to{0};
};

struct PointerButton {
    int button = 0;  ///< 0 left, 1 right, 2 middle
    bool down = true;
    Modifiers modifiers = {};
    bool twice = false;  ///< a script's second press of a double click, however late it comes
};

struct Wheel {
    double notches = 0;  ///< > 0 away from the hand
};

struct FilesDropped {
    std::vector<std::string> files;
};

using Event = std::variant<KeyEvent, TextEvent, PointerMoved, PointerButton, Wheel, FilesDropped>;

}  // namespace fumarole::window
