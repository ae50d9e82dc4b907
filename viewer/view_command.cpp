#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <memory>
#include <nlohmann/json.hpp>

#include "command.h"
#include "input_options.h"
#include "picture_files.h"
#include "planning.h"
#include "scene_input.h"
#include "settings_input.h"
#include "window/app.h"
#include "window/keys.h"
#include <fumarole/errors.h>

namespace fumarole::command {

namespace {

struct ViewOptions {
    SceneInput scene{.file = "", .size = "", .grid = "", .up = "auto"};
    SettingsInput settings;
    PlanWish plan;
    std::string size, compare, show, display, script, screenshot, save_scene;
    double frame_time = 0, exposure = 0;
    int frames = 0, aa = 0;
    std::string missing_frames = "fail";
    bool difference = false, gl_debug = false, json = false;
};

/// What is kept from the last time, then what was typed now.
void apply(const ViewOptions& options, const CLI::App& command, window::Remembered& memory)
{
    const auto given = [&](const char* name) { return command.get_option(name)->count() > 0; };
    window::ViewState& state = memory.state;
    bool settings = given("--preset") || given("--mode");
    for (const SettingInfo& info : setting_table())
        settings |= given(("--" + std::string(info.name)).c_str());
    if (settings) {
        state.settings = parse_settings(options.settings);
        state.preset = options.settings.preset;
    }
    if (given("--aa"))
        state.aa = options.aa;
    if (given("--frame-time"))
        state.target_ms = options.frame_time;
    if (given("--exposure")) {
        state.exposure_ev = static_cast<float>(options.exposure);
        state.auto_exposure = false;
    }
    if (given("--display"))
        state.transform =
            options.display == "srgb" ? Display::Transform::srgb : Display::Transform::filmic;
    if (given("--compare")) {
        state.other = options.compare;
        state.comparison =
            options.difference ? window::Comparison::difference : window::Comparison::split;
    } else if (options.difference) {
        state.comparison = window::Comparison::difference;
    }
    if (given("--show"))
        state.inspection = Inspection{.kind = find_inspection(options.show)};
    if (given("--size"))
        memory.size = parse_size(options.size);
}

void run(const ViewOptions& options, const CLI::App& command)
{
    if (!options.screenshot.empty())
        check_png("--screenshot", options.screenshot);
    if (!options.save_scene.empty() && options.scene.file.empty())
        throw UsageError("--save-scene: an empty window has no scene; give INPUT");
    window::AppOptions app;
    app.memory = window::recall(window::memory_file(), app.complaint);
    apply(options, command, app.memory);
    if (!options.script.empty())
        app.script = window::Script::read(options.script);
    app.input = options.scene;
    app.input.hold_missing = options.missing_frames == "hold";
    if (options.plan.asked())
        app.goal = parse_goal(options.plan);
    app.frames = options.frames;
    app.screenshot = options.screenshot;
    app.save_scene = options.save_scene;
    app.debug = options.gl_debug;
    const window::AppReport report = window::App(std::move(app)).run();
    if (!options.json)
        return;
    using Json = nlohmann::ordered_json;
    Json errors = Json::array();
    for (const window::ErrorFigures& side : report.errors)
        errors.push_back({{"name", side.name},
                          {"relmse", side.metrics.relmse},
                          {"bias", side.metrics.bias},
                          {"smape", side.metrics.smape},
                          {"p999", side.metrics.p999}});
    Json grids = Json::array(), files = Json::array();
    for (const window::AppReport::Grid& grid : report.grids)
        grids.push_back({{"medium", grid.medium},
                         {"name", grid.name},
                         {"type", grid.type},
                         {"voxels", grid.voxels},
                         {"role", grid.role},
                         {"error", grid.error}});
    for (const window::AppReport::File& file : report.files)
        files.push_back({{"name", file.name},
                         {"frames", file.frames},
                         {"picture", file.picture},
                         {"error", file.error}});
    const Json json{{"frames", report.frames},
                    {"first_frame_ms", report.first_frame_ms},
                    {"first_picture_ms", report.first_picture_ms},
                    {"settled_ms", report.settled_ms},
                    {"device", report.device},
                    {"message", report.message},
                    {"plan", report.plan},
                    {"notes", report.notes},
                    {"grids", grids},
                    {"files", files},
                    {"errors", errors}};
    fmt::print("{}\n", json.dump(1, ' ', false, Json::error_handler_t::replace));
}

}  // namespace

void add_view(CLI::App& app)
{
    CLI::App* command = app.add_subcommand(
        "view", "A window on a .vdb file, a scene or a sequence: orbit, light, compare");
    auto options = std::make_shared<ViewOptions>();
    ViewOptions& o = *options;
    command->add_option(
        "INPUT", o.scene.file,
        "a .vdb or .nvdb file, smoke_####.vdb, or a scene file (.json) [an empty window]");
    command->add_option("--size", o.size, "width and height of the window [the last one's]")
        ->type_name("WxH");
    add_grid_options(*command, o.scene.grid, o.scene.up);
    command->add_option("--aa", o.aa, "frames averaged at rest [16]")
        ->type_name("N")
        ->check(within(1, 65536));
    command
        ->add_option("--frame-time", o.frame_time,
                     "of a frame, held while things move, by lower resolution and fewer steps "
                     "(1..10000) [33]")
        ->type_name("MILLISECONDS")
        ->check(within(1.0, 10000.0));
    command
        ->add_option("--compare", o.compare,
                     "split the screen with a mode, a preset or the reference")
        ->type_name("NAME")
        ->check(CLI::IsMember(window::others()));
    command->add_flag("--difference", o.difference, "their difference instead of a split screen");
    std::vector<std::string> kinds;
    for (const InspectionInfo& info : inspection_table())
        kinds.emplace_back(info.name);
    command->add_option("--show", o.show, "see inside instead of the picture")
        ->type_name("KIND")
        ->check(CLI::IsMember(kinds));
    command->add_option("--exposure", o.exposure, "of the picture [as suits it]")
        ->type_name("STOPS")
        ->check(within(-40.0, 40.0));
    command
        ->add_option("--display", o.display,
                     "of the screen: a filmic curve, or srgb, which cuts off what is brighter than "
                     "white [filmic]")
        ->check(CLI::IsMember({"filmic", "srgb"}));
    command->add_option("--mode", o.settings.mode, "how media are drawn [the preset's]")
        ->check(CLI::IsMember({"raymarch", "froxel"}));
    add_settings(*command, o.settings);
    add_plan_options(*command, o.plan);
    command
        ->add_option("--frames", o.frames,
                     "close after so many frames, those of a script not counted")
        ->type_name("N")
        ->check(within(1, 1000000));
    command
        ->add_option("--missing-frames", o.missing_frames,
                     "where a frame's file is missing or broken: fail, or hold the one before it "
                     "and play on [fail]")
        ->check(CLI::IsMember({"fail", "hold"}));
    command
        ->add_option("--screenshot", o.screenshot,
                     "a picture of the window at its end; without --frames that is when the "
                     "picture is sharp")
        ->type_name("FILE.png");
    command
        ->add_option("--save-scene", o.save_scene,
                     "write the scene of INPUT as it was opened; Ctrl+S writes it as edited")
        ->type_name("FILE.json");
    command->add_option("--script", o.script, "actions in a person's stead")
        ->type_name("FILE.json");
    command->add_flag("--gl-debug", o.gl_debug, "an OpenGL error ends the program");
    command->add_flag("--json", o.json, "print JSON at the end");
    command->footer(window::key_help() +
                    "\nSettings, the last files and the window's size are kept in " +
                    "$XDG_CONFIG_HOME/fumarole/view.json.");
    command->callback([options, command] { run(*options, *command); });
}

}  // namespace fumarole::command
