#include "window/planner.h"

#include <fmt/format.h>
#include <utility>

#include "context/headless_context.h"
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
                    const study::PlanGoal& goal, bool software)
{
    mail_ = std::make_shared<Mail>();
    task_.run([=, mail = mail_](const Background::Stop& stop) {
        Answer answer;
        try {
            using Backend = gl::HeadlessContext::Backend;
            const auto context =
                gl::HeadlessContext::make(software ? Backend::osmesa : Backend::egl);
            SceneRenderer renderer(context->get_proc());
            study::PlanOptions options;
            options.preset = preset;
            options.start = settings;
            options.cancel = &stop;
            options.progress = [&](std::string_view what, double share) {
                const std::lock_guard lock(mail->lock);
                mail->progress = fmt::format("plan: {}, {:.0f} %", what, 100 * share);
            };
            answer = answer_of(study::make_plan(scene, renderer, goal, options));
        } catch (const study::PlanCancelled&) {
            return;
        } catch (const std::exception& error) {
            answer.error = error.what();
        }
        const std::lock_guard lock(mail->lock);
        mail->answer = std::move(answer);
    });
}

std::string Planner::progress() const
{
    const std::lock_guard lock(mail_->lock);
    return mail_->progress;
}

std::optional<Planner::Answer> Planner::take()
{
    const std::lock_guard lock(mail_->lock);
    return std::exchange(mail_->answer, std::nullopt);
}

}  // namespace fumarole::window
