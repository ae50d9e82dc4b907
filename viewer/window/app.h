#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scene_input.h"
#include "study/plan_search.h"
#include "window/automation.h"
#include "window/browser_panel.h"
#include "window/document.h"
#include "window/file_browser.h"
#include "window/gui.h"
#include "window/keys.h"
#include "window/layout.h"
#include "window/notices.h"
#include "window/panels.h"
#include "window/planner.h"
#include "window/pointer_input.h"
#include "window/run_log.h"
#include "window/screen.h"
#include "window/user_files.h"
#include "window/viewport.h"

namespace fumarole::window {

struct AppOptions {
    command::SceneInput input;  ///< file "" for an empty window
    Remembered memory;
    std::optional<study::PlanGoal> goal;  ///< settings are looked for once the scene is there
    Script script;
    int frames = 0;          ///< as Automation takes it
    std::string screenshot;  ///< file for a picture of the window at the end
    std::string save_scene;  ///< file for the scene, once it is read; "" for none
    bool debug = false;      ///< an OpenGL error ends the program
    std::string complaint;   ///< complaint to be said in the window at the start
};

/// The window of `fumarole view`. Once a frame: what comes in changes the document and the state,
/// the viewport draws them, and panels and overlay tell of it.
class App {
public:
    /// @throws Error as GlfwWindow
    explicit App(AppOptions options);

    /// Until the window is closed. @throws Error if a script fails, or if OpenGL does and `debug`
    AppReport run();

private:
    void frame();
    void draw(double seconds);
    /// What the library says: a note, in the words of the command line.
    void hear(std::string_view line);
    /// Seconds that a frame may wait for something to come in.
    [[nodiscard]] double poll_timeout() const;
    [[nodiscard]] bool settled() const;

    // What comes in: files, a script, a person's events.
    void open(const std::string& file);
    /// @throws Error if the scene is to be saved and can't be
    void take_loaded();
    void play(double seconds);
    std::vector<Event> follow_script(double seconds);
    void perform(const ScriptAction& action, std::vector<Event>& events);
    void handle(const Event& event);
    void handle_key(const KeyEvent& key);
    void act(Action action);
    void save(Action action);
    /// Shows the files of a folder; of the open file's, or of that of last time, if it is "".
    void browse(const std::string& folder);

    // What is shown of it besides the picture.
    void divide_window();
    void draw_panels();
    void grant(const PanelWishes& wishes);
    void update_plan();
    void report_content(AppReport& report) const;

    [[nodiscard]] ViewState& state() { return memory_.state; }
    [[nodiscard]] const ViewState& state() const { return memory_.state; }

    Screen screen_;
    Gui gui_;
    Layout layout_;
    Panels panels_;
    Notices notices_;
    Remembered memory_;
    Document document_;
    PointerInput pointer_;
    Viewport viewport_;
    Planner planner_;
    FileBrowser browser_;
    BrowserPanel browser_panel_;
    Automation automation_;
    RunLog log_;
    std::string save_scene_;  ///< file that the scene is still to be written to
};

}  // namespace fumarole::window
