#pragma once

#include <deque>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "window/event.h"

namespace fumarole::window {

// What a script can do besides a person's gestures.
struct SetSetting {
    std::string name, value;
};
struct OpenFile {
    std::string file;
};
struct Screenshot {
    std::string file;
};
struct ResizeWindow {
    glm::ivec2 size{0};
};
struct Minimise {
    bool on = true;
};
struct GiveRole {
    std::string grid, role;
    std::size_t medium = 0;
};
struct Browse {
    std::string folder;
};
struct WriteClipboard {
    std::string file;
};
using ScriptAction = std::variant<Event, SetSetting, OpenFile, Screenshot, ResizeWindow, Minimise,
                                  GiveRole, Browse, WriteClipboard>;

/// What a script can wait for, as the window knows it.
struct ScriptStatus {
    bool loaded = false;      ///< nothing is on its way in
    bool settled = false;     ///< the picture is as sharp as it gets
    bool reference = false;   ///< the reference is whole
    bool plan = false;        ///< settings were looked for and found
    bool grids = false;       ///< the grids are listed, and are what they were asked to be
    bool thumbnails = false;  ///< the browser has a picture, or an error, of all that is seen in it
    bool message = false;     ///< an error message stands in the window
    int frame = 0;            ///< that the playhead is at
};

/// Actions of a file, in order, in a person's stead:
///   [{"wait": "loaded"}, {"key": "S"}, {"key": "Ctrl+C"}, {"text": "abc"}, {"click": [x, y],
///   "double": true},
///    {"drag": [[x, y], [x, y]], "button": "left", "shift": true, "frames": 8},
///    {"wheel": 2, "at": [x, y]}, {"move": [x, y]}, {"set": {"steps": 32}}, {"open": "x.vdb"},
///    {"drop": ["x.vdb"]}, {"resize": [w, h]}, {"minimise": true}, {"frames": 10},
///    {"grid": {"flame": "emission"}, "medium": 0}, {"browse": "folder"},
///    {"wait": "settled"}, {"screenshot": "x.png"}, {"clipboard": "x.txt"}]
/// `wait` takes loaded, settled, reference, plan, grids, thumbnails, message or {"frame": N}; it
/// gives up after "seconds" (60), which is an error.
class Script {
public:
    Script() = default;
    /// @throws Error naming the file, the action by its number, and what is wrong
    static Script read(const std::filesystem::path& file);

    /// What is to be done in this frame. @param seconds since the last frame
    /// @throws Error if what is waited for does not come
    std::vector<ScriptAction> step(const ScriptStatus& status, double seconds);

    [[nodiscard]] bool done() const { return steps_.empty(); }

private:
    struct Wait {
        std::string what;  ///< `loaded`, ..., `frame`, `frames`
        int number = 0;
        double seconds = 60;
        int action = 0;  ///< its number in the file
    };
    /// A frame's actions, or a wait.
    using Step = std::variant<std::vector<ScriptAction>, Wait>;

    static bool over(Wait& wait, const ScriptStatus& status);

    std::string file_;
    std::deque<Step> steps_;
    double waited_ = 0;
};

}  // namespace fumarole::window
