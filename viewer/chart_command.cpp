#include <chrono>
#include <cstdio>
#include <fmt/format.h>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>
#include <unistd.h>

#include "asset/auto_scene.h"
#include "asset/scene_file.h"
#include "chart_log.h"
#include "command.h"
#include "errors.h"
#include "gl/headless_context.h"
#include "interruption.h"
#include "progress.h"
#include "scene_input.h"
#include "scene_renderer.h"
#include "study/chart.h"
#include "study/chart_plot.h"
#include "study/chart_report.h"
#include "study/reference_cache.h"
#include "study/whole_file.h"

namespace fumarole::command {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

struct Options {
    std::string input, output, size, grid, up = "auto", backend = "osmesa", target = "composite";
    std::optional<double> tolerance;
    std::optional<int> frames;
    bool quick = false, fresh = false, json = false;
};

/// What a chart may take, and how closely it looks.
struct Effort {
    double tolerance;  ///< of the reference
    int frames, rounds, seeds;
    double seconds;  ///< in all
};
constexpr Effort kWhole{.tolerance = 1e-3, .frames = 3, .rounds = 3, .seeds = 4, .seconds = 600};
constexpr Effort kQuick{.tolerance = 1e-2, .frames = 2, .rounds = 2, .seeds = 2, .seconds = 58};
constexpr double kWritingSeconds = 6;  ///< of all, for plot and report

std::string shell_word(const std::string& text)
{
    constexpr std::string_view kPlain =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./=:,+@%";
    if (!text.empty() && text.find_first_not_of(kPlain) == std::string::npos)
        return text;
    std::string quoted = "'";
    for (const char c : text)
        quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return quoted + "'";
}

std::string render_command(const Options& options, const Scene& scene)
{
    std::string command = fmt::format("fumarole render {} --size {}x{}", shell_word(options.input),
                                      scene.resolution.x, scene.resolution.y);
    if (!options.grid.empty())
        command += " --grid " + shell_word(options.grid);
    if (options.up != "auto")
        command += " --up " + options.up;
    if (options.backend != "osmesa")
        command += " --backend " + options.backend;
    return command;
}

/// Before hours of work: is there a folder that takes files?
void make_folder(const fs::path& folder)
{
    std::error_code error;
    fs::create_directories(folder, error);
    if (!fs::is_directory(folder))
        throw Error(fmt::format("-o: {}: no folder can be made there{}{}", folder.string(),
                                error ? ": " : "", error ? error.message() : ""));
    if (::access(folder.c_str(), W_OK | X_OK) != 0)
        throw Error(fmt::format("-o: {}: no right to write there", folder.string()));
}

double seconds_since(Clock::time_point begin)
{
    return std::chrono::duration<double>(Clock::now() - begin).count();
}

// ------------------------------------------------------------------------------------- machine

std::string cpu_name()
{
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);)
        if (line.starts_with("model name"))
            if (const std::size_t colon = line.find(": "); colon != std::string::npos)
                return line.substr(colon + 2);
    return "unknown";
}

/// Of the program itself: another build may be faster, and then its points are others.
std::string build_hash()
{
    return study::file_hash("/proc/self/exe");
}

// -------------------------------------------------------------------------------------- output

struct Made {
    fs::path csv, svg, png, report;
    std::string plot_failure;  ///< why there is no picture
    double seconds = 0;
};

Json point_json(const study::MeasuredPoint& p)
{
    Json settings, targets;
    for (const SettingInfo& info : setting_table())
        settings[std::string(info.name)] = info.get(p.point.settings);
    for (std::size_t t = 0; t < study::kTargetNames.size(); ++t) {
        const study::TargetError& e = p.errors.targets[t];
        targets[std::string(study::kTargetNames[t])] = {
            {"relmse", e.relmse},       {"relmse_min", e.relmse_min}, {"relmse_max", e.relmse_max},
            {"bias_part", e.bias_part}, {"variance", e.variance},     {"bias", e.bias}};
    }
    Json json{{"point", p.point.name()},   {"mode", p.point.mode},
              {"preset", p.point.preset},  {"arguments", p.point.arguments()},
              {"front", p.front},          {"volume_ms", p.median_ms},
              {"volume_ms_min", p.min_ms}, {"volume_ms_max", p.max_ms},
              {"visits", p.visits},        {"frames", p.frames},
              {"samples", p.samples},      {"gpu_bytes", p.gpu_bytes},
              {"seeds", p.errors.seeds},   {"flip", p.errors.flip},
              {"targets", targets},        {"settings", settings}};
    json["refusal"] = p.refusal.empty() ? Json() : Json(p.refusal);
    return json;
}

void print_json(const study::Chart& chart, const study::KeptReference& reference,
                const Options& options, const Made& made, double tolerance)
{
    Json points = Json::array(), outputs = Json::array();
    for (const study::MeasuredPoint& p : chart.points)
        points.push_back(point_json(p));
    for (const fs::path& file : {made.csv, made.svg, made.png, made.report})
        if (!file.empty())
            outputs.push_back(file.string());
    const Json json{{"input", options.input},
                    {"size", {chart.size.x, chart.size.y}},
                    {"target", options.target},
                    {"quick", options.quick},
                    {"floor", chart.floor},
                    {"reference",
                     {{"file", reference.file.string()},
                      {"reused", reference.reused},
                      {"seconds", reference.seconds},
                      {"tolerance", tolerance}}},
                    {"timing", chart.timing_method},
                    {"rounds", chart.rounds},
                    {"visits_made", chart.visited},
                    {"seconds", made.seconds},
                    {"points", points},
                    {"limits", chart.limits},
                    {"outputs", outputs}};
    fmt::print("{}\n", json.dump(1, ' ', false, Json::error_handler_t::replace));
}

void print_row(const std::string& number, const study::Chart& chart, const study::MeasuredPoint& p)
{
    const study::TargetError& e = p.error(chart.target);
    fmt::print("{:>3}  {:<52}{:>9.2f}{:>11.3e}{:>11.2e}{:>10.2e}{:>9.4f}\n", number, p.point.name(),
               p.median_ms, e.relmse, e.bias_part, e.variance, p.errors.flip);
}

void print_table(const study::Chart& chart, const study::KeptReference& reference,
                 const Options& options, const Made& made, double tolerance)
{
    fmt::print("{} at {} x {}: {} points, {} visit{} each ({} made now), reference to {:g} {}\n",
               options.input, chart.size.x, chart.size.y, chart.points.size(), chart.rounds,
               chart.rounds == 1 ? "" : "s", chart.visited, tolerance,
               reference.reused ? "reused" : "in " + duration(reference.seconds));
    fmt::print("{:>3}  {:<52}{:>9}{:>11}{:>11}{:>10}{:>9}\n", "no.",
               fmt::format("the front, by the {}", options.target), "ms", "relMSE", "bias part",
               "variance", "FLIP");
    int number = 0;
    for (const study::MeasuredPoint* p : chart.front())
        print_row(fmt::format("{}", ++number), chart, *p);
    fmt::print("     presets\n");
    for (const study::MeasuredPoint& p : chart.points)
        if (p.point.changes.empty() && p.refusal.empty())
            print_row(p.front ? "*" : "", chart, p);
    fmt::print("floor: {:.3e}, the least error that any point reached\n", chart.floor);
    for (const std::string& limit : chart.limits)
        fmt::print("note: {}\n", limit);
    for (const fs::path& file : {made.csv, made.svg, made.png, made.report})
        if (!file.empty())
            fmt::print("wrote {}\n", file.string());
    fmt::print("{}\n", duration(made.seconds));
}

study::Target parse_target(const std::string& name)
{
    const auto at = std::find(study::kTargetNames.begin(), study::kTargetNames.end(), name);
    return static_cast<study::Target>(at - study::kTargetNames.begin());
}

std::vector<std::pair<std::string, std::string>>
machine_of(const Renderer& renderer, const study::Chart& chart, const study::ChartOptions& chosen,
           const study::KeptReference& reference, double tolerance)
{
    const gl::Capabilities& gl = renderer.device().capabilities();
    return {
        {"renderer", gl.renderer},
        {"OpenGL", gl.version},
        {"processor", fmt::format("{}, {} cores", cpu_name(), std::thread::hardware_concurrency())},
        {"timing", fmt::format("{}; median over {} visits of {} frames each, after a frame "
                               "that is not timed, points in shuffled order",
                               chart.timing_method, chart.rounds, chosen.frames)},
        {"errors", fmt::format("single frames of {} seeds, pixel centres; FLIP of the first "
                               "seed's composite through the filmic transform",
                               chosen.seeds)},
        {"reference", fmt::format("tolerance {:g} of each pixel, pixel centres; {}", tolerance,
                                  reference.file.filename().string())},
        {"fumarole", FUMAROLE_VERSION}};
}

void run(const Options& options)
{
    const Clock::time_point begin = Clock::now();
    const Effort& effort = options.quick ? kQuick : kWhole;
    const double tolerance = options.tolerance.value_or(effort.tolerance);
    const asset::LoadedScene loaded =
        load_input({options.input, options.size, options.grid, options.up});
    const Scene& scene = loaded.scene;
    if (scene.media.empty())
        throw Error(
            fmt::format("{}: the scene has no media; there is nothing to chart", options.input));
    const fs::path folder = options.output.empty()
                                ? fs::path(fs::path(options.input).stem().string() + "_chart")
                                : fs::path(options.output);
    make_folder(folder);

    const Interruption interruption;
    Progress line;
    const fs::path log_file = folder / "chart.partial.jsonl";
    try {
        // Before the reference: a machine without OpenGL says so at once.
        const auto context = gl::HeadlessContext::make(options.backend == "egl"
                                                           ? gl::HeadlessContext::Backend::egl
                                                           : gl::HeadlessContext::Backend::osmesa);
        SceneRenderer renderer(context->get_proc());

        study::ReferenceOptions wanted;
        wanted.tolerance = tolerance;
        wanted.cancel = Interruption::flag();
        wanted.progress = [&](double share) { line.show("reference", share); };
        line.show("reference: preparing");
        const study::KeptReference reference =
            study::keep_reference(scene, wanted, folder, FUMAROLE_VERSION);

        study::ChartOptions chosen;
        chosen.quick = options.quick;
        chosen.target = parse_target(options.target);
        chosen.frames = options.frames.value_or(effort.frames);
        chosen.rounds = effort.rounds;
        chosen.seeds = effort.seeds;
        chosen.cancel = Interruption::flag();
        ChartLog log(log_file, study::text_hash(
                                   fmt::format("{} {} {} {} {} {}", reference.key, build_hash(),
                                               renderer.renderer().device().capabilities().renderer,
                                               options.backend, chosen.frames, chosen.seeds)));
        if (!options.fresh)
            chosen.known = log.read();
        chosen.keep = [&](const study::ChartVisit& visit) { log.append(visit); };
        chosen.progress = [&](int done, int all, double left) {
            line.show(fmt::format("point {} of {}", done, all), double(done) / all, left);
        };
        chosen.seconds = effort.seconds - kWritingSeconds - seconds_since(begin);
        const study::Chart chart = study::measure_chart(scene, reference.still, renderer, chosen);

        line.show("writing");
        Made made;
        made.csv = folder / "chart.csv";
        study::write_whole(made.csv, study::chart_csv(chart));
        study::ReportFacts facts;
        facts.title = fs::path(options.input).filename().string();
        facts.command = render_command(options, scene);
        facts.machine = machine_of(renderer.renderer(), chart, chosen, reference, tolerance);
        facts.reference_file = reference.file;
        try {
            study::plot_chart(chart,
                              fmt::format("{}, {} x {}, {}", facts.title, chart.size.x,
                                          chart.size.y, facts.machine.front().second),
                              folder / "chart.svg", folder / "chart.png");
            made.svg = folder / "chart.svg";
            made.png = facts.chart_png = folder / "chart.png";
        } catch (const Error& error) {
            made.plot_failure = error.what();
        }
        made.report = folder / "report.html";
        study::write_whole(made.report,
                           study::report_html(chart, facts,
                                              study::front_pictures(chart, scene, reference.still,
                                                                    renderer, folder)));
        made.seconds = seconds_since(begin);
        line.clear();
        if (options.json)
            print_json(chart, reference, options, made, tolerance);
        else
            print_table(chart, reference, options, made, tolerance);
        if (!made.plot_failure.empty())
            throw Error(made.plot_failure);
    } catch (const study::ReferenceCancelled&) {
        throw Error("interrupted while the reference was rendered; nothing is kept of it");
    } catch (const study::ChartCancelled&) {
        throw Error(fmt::format("interrupted; {} keeps what was measured, and the same command "
                                "goes on from there",
                                log_file.string()));
    }
}

}  // namespace

void add_chart(CLI::App& app)
{
    CLI::App* command = app.add_subcommand(
        "chart", "What each setting costs in time and in error, on this very scene: chart.csv, "
                 "chart.svg, chart.png, report.html");
    auto options = std::make_shared<Options>();
    Options& o = *options;
    command->add_option("INPUT", o.input, "a .vdb file, or a scene file (.json)")->required();
    command->add_option("-o,--output", o.output, "folder, made if need be [INPUT's name_chart]");
    command->add_flag("--quick", o.quick,
                      "fewer points, under a minute; the whole takes ten at most");
    command->add_option("--target", o.target, "that the error is of [composite]")
        ->check(CLI::IsMember({"composite", "scattering", "transmittance"}));
    command->add_option("--size", o.size, "WIDTHxHEIGHT in pixels [480x270, or the scene's]");
    command->add_option("--grid", o.grid, "of a .vdb: name or name[n] [the first fog volume]");
    command->add_option("--up", o.up, "of a .vdb [auto]")->check(CLI::IsMember({"auto", "y", "z"}));
    command
        ->add_option("--tolerance", o.tolerance,
                     "relative error of the reference's pixels [1e-3, with --quick 1e-2]")
        ->check(CLI::Range(1e-6, 0.5));
    command->add_option("--frames", o.frames, "frames timed at each visit [3, with --quick 2]")
        ->check(CLI::Range(1, 1000));
    command->add_flag("--fresh", o.fresh, "measure again what an earlier run measured");
    command->add_flag("--json", o.json, "print JSON");
    command->add_option("--backend", o.backend, "OpenGL without a window [osmesa]")
        ->check(CLI::IsMember({"osmesa", "egl"}));
    command->footer("An interrupted chart goes on where it was; the reference and the points stay "
                    "in the folder.\nExit code: 0 all written, 1 not, 2 wrong command line.");
    command->callback([options] { run(*options); });
}

}  // namespace fumarole::command
