#pragma once

#include <string>
#include <utility>
#include <vector>

#include "window/script.h"

namespace fumarole::window {

/// What stands in for a person: a script, the pictures it takes of the window, and when the window
/// closes by itself.
class Automation {
public:
    /// @param frames drawn after the script, then the window closes; 0: without a last screenshot
    /// it stays, and with one it closes when the picture is as sharp as it gets
    /// @param last_screenshot file of a picture of the window at its end, or ""
    Automation(Script script, int frames, std::string last_screenshot);

    /// Whether the window draws frame after frame rather than waits for a person.
    [[nodiscard]] bool active() const
    {
        return !script_.done() || counts_frames_ || !last_screenshot_.empty();
    }

    /// What is to be done in this frame. @throws Error as Script::step
    std::vector<ScriptAction> step(const ScriptStatus& status, double seconds)
    {
        return script_.step(status, seconds);
    }

    /// A frame was drawn. Returns whether the window is to close.
    /// @param finished true if the picture is as sharp as it gets, or a message says why not
    bool ends(bool finished);

    void request_screenshot(const std::string& file) { screenshots_.push_back(file); }
    /// Asks for the last screenshot, if one was wanted. Returns whether one was.
    bool request_last_screenshot();
    [[nodiscard]] bool has_screenshots() const { return !screenshots_.empty(); }
    /// The pictures that are to be taken of this frame.
    std::vector<std::string> take_screenshots() { return std::exchange(screenshots_, {}); }
    /// @throws Error if a picture could not be taken, since no frame was drawn
    void check_screenshots() const;

private:
    Script script_;
    bool counts_frames_;
    int frames_left_;
    std::string last_screenshot_;
    std::vector<std::string> screenshots_;
};

}  // namespace fumarole::window
