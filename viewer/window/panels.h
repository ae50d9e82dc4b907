#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <vector>

#include "study/plan_search.h"
#include "window/document.h"
#include "window/keys.h"
#include "window/layout.h"
#include "window/viewport.h"

namespace fumarole::window {

/// What the panel shows and may change. Its drawing asks for deeds by filling in `PanelWishes`.
struct PanelContext {
    ViewState& state;
    Document& document;
    Viewport& viewport;
    const std::vector<std::string>& recent;
    std::string device;
    std::string plan;  ///< what the planner does, or what it chose
};

struct PanelWishes {
    Change change = Change::none;                        ///< what of the picture is out of date
    std::string open = {};                               ///< a file to open
    std::optional<study::PlanGoal> plan = std::nullopt;  ///< settings to look for
    std::vector<Action> actions = {};                    ///< buttons that were pressed
};

/// The one slider of quality, which is a plan's goal.
struct PanelQuality {
    bool by_time = false;
    float max_error = 0.01f, budget_ms = 16;
    bool due = false;  ///< moved, and not yet planned for
};

class Panels {
public:
    /// The panel at the left.
    PanelWishes draw_panel(const PanelContext& context, const Layout& layout);

    /// The bar of a scene in time, at the bottom.
    static void draw_timeline(Sequence& sequence, const Layout& layout);

    /// The keys, over all. @returns false once it is closed
    static bool draw_help(glm::vec2 size);
    /// A message with a button. @returns false once it is closed
    static bool draw_message(const std::string& text, glm::vec2 size);

private:
    void draw_sections(const PanelContext& context, PanelWishes& wishes);

    std::string path_;  ///< being typed
    PanelQuality quality_;
};

}  // namespace fumarole::window
