#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "study/metrics.h"
#include "study/plan_search.h"
#include "window/playback.h"
#include "window/reference_worker.h"
#include "window/side.h"
#include "window/user_files.h"
#include "window/view_state.h"

namespace fumarole::window {

/// Error figures of a side against the reference, over what there is of it.
struct ErrorFigures {
    std::string name;
    study::Metrics metrics;
};

/// What the panel shows and may change. Its drawing asks for deeds by filling in `wishes`.
struct PanelContext {
    ViewState& state;
    Scene& scene;
    const Scene& first;  ///< as it was read: what resets go back to
    bool whole = false;  ///< all of the scene is there: it may be changed
    const std::vector<std::string>& notes;
    const std::vector<std::string>& recent;
    std::string file;
    std::string loading;  ///< what is being read, or ""
    const Side& side;
    const Side* other = nullptr;
    double samples = 0;
    double frame_ms = 0;
    const std::vector<float>& history_ms;  ///< of the last frames, the oldest first
    int effort_level = 0, effort_levels = 1;
    glm::ivec2 pixels{0};  ///< of the picture as it is drawn now
    const ReferenceWorker::Picture& reference;
    bool reference_runs = false;
    const std::vector<ErrorFigures>& errors;
    const char* timing_method = "";
    const char* device = "";
    std::string plan;  ///< what it does, or what it chose
    /// What the scene needs, a line each: not free, so asked for by whom it is shown alone.
    std::function<std::vector<std::string>()> explain;
};

struct PanelWishes {
    bool view_changed = false;                           ///< a setting
    bool content_changed = false;                        ///< media, lights, world
    std::string open = {};                               ///< a file to open
    std::optional<study::PlanGoal> plan = std::nullopt;  ///< settings to look for
    bool fit = false, first_camera = false;
    bool copy_command = false, save_png = false, save_exr = false, save_scene = false;
};

class Panels {
public:
    /// The panel at the left. @param width, height in the window's units
    PanelWishes draw_panel(const PanelContext& context, float width, float height);

    /// The bar of a scene in time, at the bottom. @returns whether a frame was chosen
    bool draw_timeline(Playback& playback, int frames_there, bool waits, glm::vec2 at,
                       glm::vec2 size);

    /// The keys, over all. @returns false once it is closed
    static bool draw_help(glm::vec2 size);
    /// A message with a button. @returns false once it is closed
    static bool draw_message(const std::string& text, glm::vec2 size);
    /// What is in the middle of an empty window.
    static void draw_greeting(const std::string& text, glm::vec2 at, glm::vec2 size);
    /// The colours' meaning, at the lower right corner.
    static void draw_legend(const std::string& caption, double low, double high,
                            const std::string& unit, glm::vec2 corner);

private:
    std::string path_;  ///< being typed
    float max_error_ = 0.01f, budget_ms_ = 16;
};

}  // namespace fumarole::window
