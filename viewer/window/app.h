#pragma once

#include <array>
#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "scene_input.h"
#include "window/display_pass.h"
#include "window/document.h"
#include "window/frame_store.h"
#include "window/glfw_window.h"
#include "window/gui.h"
#include "window/keys.h"
#include "window/pace.h"
#include "window/panels.h"
#include "window/planner.h"
#include "window/playback.h"
#include "window/reference_worker.h"
#include "window/scene_handles.h"
#include "window/script.h"
#include "window/side.h"
#include "window/user_files.h"

namespace fumarole::window {

struct AppOptions {
    command::SceneInput input;  ///< file "" for an empty window
    Remembered memory;
    std::filesystem::path memory_file;    ///< "" keeps nothing
    std::optional<study::PlanGoal> goal;  ///< settings are looked for once the scene is there
    Script script;
    int frames = 0;          ///< drawn after the script, then the window closes; 0: it stays
    std::string screenshot;  ///< of the window, at the end
    bool debug = false;      ///< an OpenGL error ends the program
    std::string complaint;   ///< to be said in the window at the start
};

/// What a run did, for machines.
struct AppReport {
    int frames = 0;
    double first_frame_ms = 0;    ///< until the window first showed something
    double first_picture_ms = 0;  ///< until it first showed a whole scene, 0 if never
    double settled_ms = 0;        ///< until that was as sharp as it gets, 0 if never
    std::string device;
    std::string message;               ///< that stood in the window at the end
    std::vector<ErrorFigures> errors;  ///< against the reference, at the end
};

/// The window of `fumarole view`: what comes in, what is shown, once a frame.
class App {
public:
    /// @throws Error as GlfwWindow
    explicit App(AppOptions options);
    ~App();

    /// Until the window is closed. @throws Error if a script fails, or if OpenGL does and `debug`
    AppReport run();

private:
    using Clock = std::chrono::steady_clock;
    enum class Drag { none, orbit, pan, look, wipe, light };

    /// The picture's part of the window, in the window's units from its top left.
    struct Area {
        glm::dvec2 at{0}, size{0};
        [[nodiscard]] bool holds(glm::dvec2 p) const
        {
            return glm::all(glm::greaterThanEqual(p, at)) && glm::all(glm::lessThan(p, at + size));
        }
        [[nodiscard]] glm::dvec2 share(glm::dvec2 p) const { return (p - at) / size; }
        [[nodiscard]] double aspect() const { return size.x / size.y; }
    };

    void frame();
    [[nodiscard]] double patience() const;
    /// Seconds since the start.
    [[nodiscard]] double now() const;
    std::vector<Event> follow_script(double seconds);
    void lay_out();

    // what comes in
    void open(const std::string& file);
    void take_news();
    void show_frame(double seconds);
    void handle(const Event& event);
    void handle_key(const KeyEvent& key);
    void handle_button(const PointerButton& button);
    void handle_move(glm::dvec2 to);
    void fly(double seconds);
    void act(Action action);
    void see_next_inside();

    // what goes out
    void draw_panels();
    void grant(const PanelWishes& wishes);
    void draw_sides();
    bool draw_side(Side& side, const Settings& settings);
    void draw_picture();
    void draw_overlays();
    void update_plan();
    void update_reference();
    void update_errors();
    void update_exposure();
    void update_difference();
    [[nodiscard]] SideRequest request(const Settings& settings) const;
    [[nodiscard]] Shown shown(const Side& side) const;
    [[nodiscard]] glm::ivec2 picture_pixels(double scale) const;
    [[nodiscard]] glm::ivec2 area_pixels() const;

    // deeds
    [[nodiscard]] std::string output_name(const char* extension) const;
    [[nodiscard]] std::string input_words();
    void save_picture(const std::string& file);
    void copy_command();
    void take_screenshot(const std::string& file) const;
    void check_gl();
    void say(const std::string& message) { message_ = message; }

    void change_view() { changed_ = true; }
    void change_content()
    {
        changed_ = content_changed_ = true;
        exposure_due_ = true;
    }
    [[nodiscard]] bool settled() const;
    [[nodiscard]] bool compares() const { return state_.comparison != Comparison::none; }

    AppOptions options_;
    GlfwWindow window_;
    Gui gui_;
    gl::Device gl_;
    DisplayPass display_;
    Panels panels_;
    Document document_;
    ReferenceWorker reference_worker_;
    Planner planner_;
    std::unique_ptr<FrameStore> frames_;
    Playback playback_;
    Pace pace_;
    std::unique_ptr<Side> a_, b_;

    ViewState state_;
    Scene scene_, first_;
    std::vector<std::string> notes_;
    std::string file_;
    bool whole_ = false, free_camera_ = false;
    int shown_frame_ = 0;

    Area area_;
    float timeline_height_ = 0;
    float panel_width_ = 0;
    Drag drag_ = Drag::none;
    std::size_t dragged_light_ = 0;
    glm::dvec2 pointer_{-1};
    std::array<bool, 6> flying_{};  ///< right, left, up, down, forward, back

    bool changed_ = true, content_changed_ = false, content_moves_ = false;
    bool exposure_due_ = true, scene_is_new_ = true;
    std::string failed_, message_;  ///< a message that a drawing gave, until something changes
    std::string note_;              ///< a line at the bottom, for a while
    double note_seconds_ = 0;
    std::string plan_text_;  ///< what the last plan chose
    bool plan_due_ = false;

    ReferenceWorker::Picture reference_;
    gl::Texture reference_texture_;
    std::uint64_t reference_shown_ = 0;
    std::optional<std::pair<Scene, double>> reference_of_;
    double reference_seen_ = -1;  ///< seconds since the start
    std::vector<ErrorFigures> errors_;
    double difference_scale_ = 1, tenth_of_mean_square_ = 0;

    std::vector<float> frame_times_;
    double frame_ms_ = 0, samples_ = 0;
    std::vector<std::string> gl_errors_;
    Clock::time_point begin_ = Clock::now();
    double last_ = 0;  ///< frame's beginning, seconds since the start
    AppReport report_;
    int frames_left_ = 0;
    std::vector<std::string> screenshots_;  ///< to be taken of this frame
};

}  // namespace fumarole::window
