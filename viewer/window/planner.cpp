#include "window/planner.h"

#include "study/flag_names.h"
#include <fmt/format.h>
#include <utility>

#include "context/headless_context.h"
#include "kept_programs.h"
#include "library_log.h"
#include "planning.h"
#include "window/glfw_window.h"

namespace fumarole::window {

namespace {

/// The settings of a choice: the start's, and what its words change.
Planner::Answer answer_of(const study::Plan& plan)
{
    Planner::Answer answer;
    answer.settings = plan.chosen().tried.settings;
    answer.text = command::choice_text(plan);
    return answer;
}

}  // namespace

void Planner::start(const Scene& scene, const Settings& settings, const std::string& preset,
                    bool software)
{
    const study::PlanGoal goal = *std::exchange(goal_, std::nullopt);
    shared_ = std::make_shared<Shared>();
    task_.run([=, shared = shared_](const Background::Stop& stop) {
        Answer answer;
        try {
            const auto context =
                gl::HeadlessContext::make(software ? gl::Backend::osmesa : gl::Backend::automatic);
            SceneRenderer renderer(context->get_proc(), command::library_log(),
                                   command::kept_programs());
            study::PlanOptions options;
            options.preset = preset;
            options.start = settings;
            options.cancel = &stop;
            options.progress = [&](std::string_view what, double share) {
                const std::lock_guard lock(shared->lock);
                shared->progress = fmt::format("plan: {}, {:.0f} %", what, 100 * share);
            };
            answer = answer_of(study::make_plan(scene, renderer, goal, options));
        } catch (const study::PlanCancelled&) {
            return;
        } catch (const std::exception& error) {
            answer.error = study::with_flags(error.what());
        }
        const std::lock_guard lock(shared->lock);
        shared->answer = std::move(answer);
    });
}

std::string Planner::text() const
{
    if (!busy())
        return text_;
    const std::lock_guard lock(shared_->lock);
    return shared_->progress;
}

std::optional<Planner::Answer> Planner::take()
{
    const std::lock_guard lock(shared_->lock);
    std::optional<Answer> answer = std::exchange(shared_->answer, std::nullopt);
    if (answer && answer->error.empty())
        text_ = answer->text;
    return answer;
}

}  // namespace fumarole::window
