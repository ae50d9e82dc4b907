#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <memory>
#include <nlohmann/json.hpp>

#include "command.h"
#include "device_options.h"
#include "input_options.h"
#include "interruption.h"
#include "kept_programs.h"
#include "library_log.h"
#include "planning.h"
#include "progress.h"
#include "scene_input.h"
#include "shell_words.h"
#include "study/seconds.h"
#include <fumarole/asset/scene_file.h>

namespace fumarole::command {

namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

struct PlanOptions {
    std::string input, size, grid, up = "auto";
    DeviceOptions device;
    SettingsInput words;
    PlanWish wish;
    double time_limit = 10;  ///< seconds
    bool json = false;
};

std::string render_command(const PlanOptions& options, const study::Plan& plan)
{
    const std::string& name = plan.chosen().name;
    return fmt::format("fumarole render {}", shell_word(options.input)) +
           option_text("--size", options.size) + option_text("--grid", options.grid) +
           option_text("--up", options.up, "auto") + device_text(options.device) +
           (name.empty() ? "" : " " + name);
}

/// Those on the front, fastest first, and the choice and the start, if they are not on it.
std::vector<const study::PlanPoint*> told_points(const study::Plan& plan)
{
    std::vector<const study::PlanPoint*> told;
    for (std::size_t i = 0; i < plan.points.size(); ++i)
        if (plan.points[i].front || i == 0 || i == plan.choice)
            told.push_back(&plan.points[i]);
    std::sort(told.begin(), told.end(),
              [](const auto* a, const auto* b) { return a->tried.ms < b->tried.ms; });
    return told;
}

// The two standard errors differ upwards and downwards: what is printed is the one upwards.
std::string error_text(double error, double surely)
{
    return fmt::format("{:.2e} + {:.0e}", error, surely - error);
}

std::string fact_text(const study::PlanFact& fact)
{
    if (fact.errors)
        return fmt::format("{}, which gain{}: the error is {:.2e}, and {:.2e} without", fact.text,
                           fact.text.starts_with("light") ? "s" : "", fact.errors->first,
                           fact.errors->second) +
               (fact.saving
                    ? fmt::format("; a frame of the volume takes {:+.0f} %", -100 * *fact.saving)
                    : "");
    constexpr double kNothing = 0.03;  // by which frames of one setting differ
    if (!fact.saving)
        return fact.text;
    if (std::abs(*fact.saving) < kNothing)
        return fact.text + ", which saves nothing that could be measured";
    return fmt::format("{}, {:.0f} % {}", fact.text, 100 * std::abs(*fact.saving),
                       *fact.saving > 0 ? "less" : "more");
}

void print_plan(const study::Plan& plan, const Scene& scene, const PlanOptions& options,
                const std::string& device)
{
    fmt::print("on {}\n", device);
    fmt::print("what this scene needs:\n");
    for (const study::PlanFact& fact : plan.facts)
        fmt::print("  {}\n", fact_text(fact));
    fmt::print("{} settings tried at {} x {} ({}), those that no other one beats:\n",
               plan.points.size(), scene.resolution.x, scene.resolution.y, plan.timing_method);
    fmt::print("{:>10}  {:<20}{:<20}settings\n", "ms", "predicted error", "on fresh pixels");
    for (const study::PlanPoint* point : told_points(plan))
        fmt::print("{:>10.2f}  {:<20}{:<20}{}{}\n", point->tried.ms,
                   error_text(point->tried.error, point->tried.surely),
                   error_text(point->verified.error, point->verified.surely),
                   point->name.empty() ? "the default" : point->name,
                   point == &plan.chosen() ? "   <- chosen" : "");
    fmt::print("an error is the root of relMSE of the composite, one frame, against references of "
               "{} pixels to {:g} each; + is one standard error\n",
               plan.pixels, plan.tolerance);
    for (const std::string& note : plan.notes)
        fmt::print("note: {}\n", note);
    fmt::print("{}\n", choice_text(plan));
    if (plan.choice != 0)
        fmt::print("timed anew: {:.2f} ms, where the search began {:.2f} ms\n", plan.ms,
                   plan.start_ms);
    fmt::print("{}\n{:.1f} s\n", render_command(options, plan), plan.seconds);
}

Json point_json(const study::PlanPoint& point)
{
    Json settings;
    for (const SettingInfo& info : setting_table())
        settings[std::string(info.name)] = info.get(point.tried.settings);
    return {{"arguments", point.name},
            {"mode", mode_name(point.tried.settings.mode)},
            {"ms", point.tried.ms},
            {"predicted", point.tried.error},
            {"predicted_upper", point.tried.surely},
            {"verified", point.verified.error},
            {"verified_upper", point.verified.surely},
            {"front", point.front},
            {"settings", settings}};
}

void print_json(const study::Plan& plan, const Scene& scene, const PlanOptions& options,
                const Json& device)
{
    Json facts = Json::array(), points = Json::array();
    for (const study::PlanFact& fact : plan.facts)
        facts.push_back({{"text", fact.text},
                         {"without", fact.without ? Json(fmt::format("--{} {}", fact.without->first,
                                                                     fact.without->second))
                                                  : Json()},
                         {"saving", fact.saving ? Json(*fact.saving) : Json()},
                         {"error", fact.errors ? Json(fact.errors->first) : Json()},
                         {"error_without", fact.errors ? Json(fact.errors->second) : Json()}});
    for (const study::PlanPoint& point : plan.points)
        points.push_back(point_json(point));
    const bool for_error = plan.goal.kind == study::PlanGoal::Kind::max_error;
    Json choice = point_json(plan.chosen());
    choice["ms"] = plan.ms;
    choice["command"] = render_command(options, plan);
    Json json{{"input", options.input},
              {"size", {scene.resolution.x, scene.resolution.y}},
              {for_error ? "max_error" : "budget_ms", plan.goal.value},
              {"met", plan.met},
              {"choice", choice},
              {"start_ms", plan.start_ms},
              {"facts", facts},
              {"points", points},
              {"pixels", plan.pixels},
              {"tolerance", plan.tolerance},
              {"timing", plan.timing_method},
              {"notes", plan.notes},
              {"seconds", plan.seconds}};
    json.update(device);
    fmt::print("{}\n", json.dump(1, ' ', false, Json::error_handler_t::replace));
}

void run(const PlanOptions& options)
{
    if (!options.wish.asked())
        throw UsageError("give what to plan for: --max-error 0.01, or --budget 8ms");
    const study::PlanGoal goal = parse_goal(options.wish);
    parse_settings(options.words);  // before the scene is read
    check_device(options.device);
    const Clock::time_point begin = Clock::now();
    const asset::LoadedScene loaded =
        load_input({options.input, options.size, options.grid, options.up});
    const auto context = make_context(options.device);
    SceneRenderer renderer(context->get_proc(), library_log(), kept_programs());
    const gl::Device& device = renderer.renderer().device();
    // What the file took to read is not there any more, but a look at it must be.
    constexpr double kLeastShare = 0.5;
    const double seconds = std::max(options.time_limit - study::seconds_since(begin),
                                    kLeastShare * options.time_limit);
    const Interruption interruption;
    const study::Plan plan =
        plan_settings(loaded.scene, renderer, goal, options.words, seconds, true);
    if (options.json)
        print_json(plan, loaded.scene, options, chosen_json(*context, device));
    else
        print_plan(plan, loaded.scene, options, chosen_text(*context, device));
}

}  // namespace

void add_plan(CLI::App& app)
{
    CLI::App* command = app.add_subcommand(
        "plan", "What a scene needs, and the cheapest settings that reach an error or the most "
                "accurate ones that fit into a time");
    auto options = std::make_shared<PlanOptions>();
    PlanOptions& o = *options;
    command->add_option("INPUT", o.input, "a .vdb or .nvdb file, or a scene file (.json)")
        ->required();
    add_plan_options(*command, o.wish);
    add_size_option(*command, o.size);
    add_grid_options(*command, o.grid, o.up);
    command->add_option("--time-limit", o.time_limit, "references and tries are cut to fit [10]")
        ->type_name("SECONDS")
        ->check(within(0.1, 1e6));
    command->add_flag("--json", o.json, "print JSON");
    add_device_options(*command, o.device);
    command->add_option("--mode", o.words.mode, "one mode alone [both are tried]")
        ->check(CLI::IsMember({"raymarch", "froxel"}));
    add_settings(*command, o.words);
    command->footer("Settings that are given stay as they are; the others are searched.\nExit "
                    "code: 0 planned, the goal met or not (it says so), 1 not planned, 2 wrong "
                    "command line.");
    command->callback([options] { run(*options); });
}

}  // namespace fumarole::command
