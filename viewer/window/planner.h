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

    /// Starts over. @param scene its resolution is the picture's
    /// @param software whether the window draws on the processor, which is then planned for
    void start(const Scene& scene, const Settings& settings, const std::string& preset,
               const study::PlanGoal& goal, bool software);
    [[nodiscard]] bool busy() const { return task_.busy(); }
    /// What it does, in a few words.
    [[nodiscard]] std::string progress() const;
    /// The answer, once.
    std::optional<Answer> take();

private:
    struct Mail {
        std::mutex lock;
        std::string progress;
        std::optional<Answer> answer;
    };
    std::shared_ptr<Mail> mail_ = std::make_shared<Mail>();
    Background task_;
};

}  // namespace fumarole::window
