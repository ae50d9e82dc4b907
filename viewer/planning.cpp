#include "planning.h"

#include <CLI/CLI.hpp>
#include <charconv>
#include <fmt/format.h>

#include "command.h"
#include "interruption.h"
#include "progress.h"
#include <fumarole/errors.h>

namespace fumarole::command {

namespace {

/// `8ms`, `0.01s`; a bare number is milliseconds.
double parse_ms(const std::string& text)
{
    double value = 0;
    const char* end = text.data() + text.size();
    const auto parsed = std::from_chars(text.data(), end, value);
    std::string_view unit(parsed.ptr, static_cast<std::size_t>(end - parsed.ptr));
    unit.remove_prefix(std::min(unit.find_first_not_of(' '), unit.size()));
    const double ms = unit == "s" ? 1e3 * value : value;
    if (parsed.ec != std::errc{} || !(unit.empty() || unit == "ms" || unit == "s") ||
        !(ms > 0 && ms <= 1e6))
        throw UsageError(fmt::format("--budget: '{}' is no time; give milliseconds a frame, e.g. "
                                     "8ms",
                                     text));
    return ms;
}

}  // namespace

void add_plan_options(CLI::App& command, PlanWish& wish)
{
    CLI::Option* error = command.add_option(
        "--max-error", wish.max_error,
        "plan the cheapest settings with at most this error: the root of relMSE of the composite, "
        "one frame; 0.01 is a relMSE of 1e-4");
    error->type_name("ERROR")->check(within(1e-6, 10.0));
    command
        .add_option("--budget", wish.budget,
                    "plan the most accurate settings for which the volume adds at most this to a "
                    "frame, e.g. 8ms")
        ->type_name("TIME")
        ->excludes(error);
}

study::PlanGoal parse_goal(const PlanWish& wish)
{
    using Kind = study::PlanGoal::Kind;
    if (wish.max_error)
        return {Kind::max_error, *wish.max_error};
    return {Kind::budget, parse_ms(wish.budget)};
}

study::Plan plan_settings(const Scene& scene, SceneRenderer& renderer, const study::PlanGoal& goal,
                          const SettingsInput& words, double seconds, bool savings)
{
    Progress progress;
    study::PlanOptions options;
    options.preset = words.preset;
    options.start = parse_settings(words);
    for (const auto& [name, value] : words.changed)
        options.fixed.push_back(name);
    if (!words.mode.empty() || words.preset != "default")
        options.fixed.emplace_back("mode");
    options.seconds = seconds;
    options.savings = savings;
    options.progress = [&](std::string_view what, double share) {
        progress.show(fmt::format("plan: {}", what), share, (1 - share) * seconds);
    };
    options.cancel = Interruption::flag();
    try {
        return study::make_plan(scene, renderer, goal, options);
    } catch (const study::PlanCancelled&) {
        throw Error("interrupted while the settings were planned; nothing was written");
    }
}

std::string goal_text(const study::PlanGoal& goal)
{
    return goal.kind == study::PlanGoal::Kind::max_error ? fmt::format("error {:g}", goal.value)
                                                         : fmt::format("{:g} ms", goal.value);
}

std::string choice_text(const study::Plan& plan)
{
    const study::PlanPoint& choice = plan.chosen();
    std::string text = fmt::format(
        "planned for {}: {}, error {:.2g}, {:.1f} ms a frame", goal_text(plan.goal),
        choice.name.empty() ? "the default settings" : choice.name, choice.verified.error, plan.ms);
    if (!plan.met)
        text +=
            fmt::format("; nothing that was tried comes {}, this comes closest",
                        plan.goal.kind == study::PlanGoal::Kind::max_error ? "below that error"
                                                                           : "within that time");
    return text;
}

}  // namespace fumarole::command
