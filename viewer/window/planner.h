#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "settings_input.h"
#include "study/plan.h"
#include "window/background.h"

namespace fumarole::window {

/// Looks for settings in the background, in an OpenGL context of its own: the window goes on.
class Planner {
public:
    struct Answer {
        Settings settings;
        std::string text;  ///< what was chosen and what to expect of it
        std::string error;
    };

    /// Asks for settings, to be looked for by the next start().
    void ask(const std::optional<study::PlanGoal>& goal) { goal_ = goal; }
    /// Whether settings were asked for and start() has not been called since.
    [[nodiscard]] bool asked() const { return goal_.has_value(); }

    /// Starts to look for what was asked for; drops what it still looks for.
    /// @param scene its resolution is the picture's
    /// @param software whether the window draws on the processor, which is then planned for
    void start(const Scene& scene, const Settings& settings, const std::string& preset,
               bool software);
    [[nodiscard]] bool busy() const { return task_.busy(); }
    /// Whether all that was asked for is found, and something was.
    [[nodiscard]] bool done() const { return !asked() && !busy() && !text_.empty(); }
    /// What it does, or what it found, in a few words.
    [[nodiscard]] std::string text() const;
    /// Returns the answer, once.
    std::optional<Answer> take();

private:
    /// State shared with the thread.
    struct Shared {
        std::mutex lock;
        std::string progress;
        std::optional<Answer> answer;
    };
    std::optional<study::PlanGoal> goal_;
    std::string text_;  ///< what the last plan chose
    std::shared_ptr<Shared> shared_ = std::make_shared<Shared>();
    Background task_;
};

}  // namespace fumarole::window
