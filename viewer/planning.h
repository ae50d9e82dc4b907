#pragma once

#include <optional>
#include <string>

#include "settings_input.h"
#include "study/plan.h"

namespace CLI {
class App;
}

namespace fumarole::command {

/// What a plan is asked for, as it was typed.
struct PlanWish {
    std::optional<double> max_error;
    std::string budget;

    [[nodiscard]] bool asked() const { return max_error || !budget.empty(); }
};

/// `--max-error` and `--budget`, of which one may be given.
void add_plan_options(CLI::App& command, PlanWish& wish);

/// @throws UsageError if the words are no goal
study::PlanGoal parse_goal(const PlanWish& wish);

/// A plan from the settings as they were typed: those stay, the others are searched. Shows its
/// progress on a terminal. @throws Error as study::make_plan, and when an Interruption that lives
/// is asked for
study::Plan plan_settings(const Scene& scene, SceneRenderer& renderer, const study::PlanGoal& goal,
                          const SettingsInput& words, double seconds, bool savings);

/// `error 0.01` or `8 ms`.
std::string goal_text(const study::PlanGoal& goal);

/// What was chosen and what is to be expected of it: a line.
std::string choice_text(const study::Plan& plan);

}  // namespace fumarole::command
