#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <fmt/format.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "bounce_count.h"
#include "chart_log.h"
#include "command.h"
#include "device_options.h"
#include "gl/device.h"
#include "input_options.h"
#include "interruption.h"
#include "kept_programs.h"
#include "library_log.h"
#include "machine.h"
#include "output_folder.h"
#include "progress.h"
#include "scene_input.h"
#include "shard_option.h"
#include "shell_words.h"
#include "study/chart.h"
#include "study/chart_budget.h"
#include "study/chart_plot.h"
#include "study/chart_report.h"
#include "study/metrics.h"
#include "study/reference_cache.h"
#include "study/reference_state.h"
#include "write/whole_file.h"
#include <fumarole/asset/auto_scene.h>
#include <fumarole/asset/scene_file.h>
#include <fumarole/errors.h>
#include <fumarole/scene_renderer.h>

namespace fumarole::command {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

constexpr const char* kLogName = "chart.partial.jsonl";

struct ChartOptions {
    std::string input, output, size, grid, shard, up = "auto", target = "composite",
                                                  bounces = "all", surface_bounces = "auto";
    DeviceOptions device;
    std::optional<double> tolerance;
    std::optional<int> frames;
    std::optional<double> time_limit;  ///< seconds
    bool quick = false, fresh = false, json = false;

    /// Light scatters once in the truth and in all that is measured against it.
    [[nodiscard]] bool once() const { return bounces == "0"; }
    /// Of the truth.
    int reflections = 0;  ///< what that is of the scene
    /// Whether the truth is integrated, and no path of it is sampled.
    [[nodiscard]] bool integrated() const { return once() && reflections == 0; }
};

/// What a chart may take, and how closely it looks.
struct ChartEffort {
    double tolerance;       ///< tolerance of the reference where light scatters on
    double tolerance_once;  ///< tolerance where light scatters once
    int frames, rounds, seeds;
    double seconds;  ///< limit of the whole run [s]
};
constexpr ChartEffort kWholeChart{
    .tolerance = 0.1, .tolerance_once = 1e-3, .frames = 3, .rounds = 3, .seeds = 4, .seconds = 600};
constexpr ChartEffort kQuickChart{
    .tolerance = 0.2, .tolerance_once = 1e-2, .frames = 2, .rounds = 2, .seeds = 2, .seconds = 60};

// Of all the time: at most so much for the reference; so much stays for pictures and report.
constexpr double kReferenceShare = 0.35;
constexpr double kWritingShare = 0.04, kWritingSeconds = 5;

ChartEffort effort_of(const ChartOptions& options)
{
    ChartEffort effort = options.quick ? kQuickChart : kWholeChart;
    effort.tolerance =
        options.tolerance.value_or(options.integrated() ? effort.tolerance_once : effort.tolerance);
    effort.frames = options.frames.value_or(effort.frames);
    effort.seconds = options.time_limit.value_or(effort.seconds);
    return effort;
}

std::string render_command(const ChartOptions& options, const Scene& scene)
{
    return fmt::format("fumarole render {} --size {}x{}", shell_word(options.input),
                       scene.resolution.x, scene.resolution.y) +
           option_text("--grid", options.grid) + option_text("--up", options.up, "auto") +
           device_text(options.device);
}

/// The command that goes on with an interrupted chart: all that was said but --fresh.
std::string continue_command(const ChartOptions& options)
{
    const auto number = [](const char* name, const auto& value) {
        return value ? fmt::format(" {} {:g}", name, static_cast<double>(*value)) : "";
    };
    return fmt::format("fumarole chart {}", shell_word(options.input)) +
           (options.quick ? " --quick" : "") + option_text("--shard", options.shard) +
           option_text("-o", options.output) +
           option_text("--target", options.target, "composite") +
           option_text("--bounces", options.bounces, "all") +
           option_text("--surface-bounces", options.surface_bounces, "auto") +
           option_text("--size", options.size) + option_text("--grid", options.grid) +
           option_text("--up", options.up, "auto") + device_text(options.device) +
           number("--tolerance", options.tolerance) + number("--frames", options.frames) +
           number("--time-limit", options.time_limit) + (options.json ? " --json" : "");
}

double seconds_since(Clock::time_point begin)
{
    return std::chrono::duration<double>(Clock::now() - begin).count();
}

// ------------------------------------------------------------------------------------- machine

/// Of the program itself: another build may be faster, and then its points are others.
std::string build_hash()
{
    return study::file_hash("/proc/self/exe");
}

// -------------------------------------------------------------------------------------- output

struct Made {
    fs::path csv, svg, png, report;
    std::string plot_failure;  ///< why there is no picture
    std::string device;        ///< what was drawn with, and why
    Json device_json;
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
    Json json{{"point", p.point.name()},   {"mode", p.point.mode()},
              {"preset", p.point.preset},  {"arguments", p.point.arguments(5)},
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
                const ChartOptions& options, const Made& made, double tolerance)
{
    Json points = Json::array(), outputs = Json::array(), effects = Json::array();
    for (const study::MeasuredPoint& p : chart.points)
        points.push_back(point_json(p));
    for (const fs::path& file : {made.csv, made.svg, made.png, made.report})
        if (!file.empty())
            outputs.push_back(file.string());
    for (const study::SettingEffect& e : study::setting_effects(chart))
        effects.push_back({{"setting", e.setting},
                           {"value", e.value},
                           {"default", e.is_default},
                           {"time_ratio", e.time_ratio},
                           {"error_ratio", e.error_ratio},
                           {"verdict", e.verdict(chart.target)}});
    Json json{{"input", options.input},
              {"size", {chart.size.x, chart.size.y}},
              {"target", options.target},
              {"quick", options.quick},
              {"floor", chart.floor},
              {"reference",
               {{"file", reference.file.string()},
                {"reused", reference.reused},
                {"seconds", reference.seconds},
                {"bounces", options.once() ? Json(0) : Json("all")},
                {"surface_bounces", bounces_json(options.reflections)},
                {"tolerance", tolerance}}},
              {"timing", chart.timing_method},
              {"rounds", chart.rounds},
              {"visits_made", chart.visited},
              {"seconds", made.seconds},
              {"points", points},
              {"left_out", chart.left_out},
              {"effects", effects},
              {"limits", chart.limits},
              {"outputs", outputs}};
    json.update(made.device_json);
    fmt::print("{}\n", json.dump(1, ' ', false, Json::error_handler_t::replace));
}

void print_row(const std::string& number, const study::Chart& chart, const study::MeasuredPoint& p)
{
    const study::TargetError& e = p.error(chart.target);
    fmt::print("{:>3}  {:<52}{:>9.2f}{:>11.3e}{:>11.2e}{:>10.2e}{:>9.4f}\n", number, p.point.name(),
               p.median_ms, e.relmse, e.bias_part, e.variance, p.errors.flip);
}

void print_table(const study::Chart& chart, const study::KeptReference& reference,
                 const ChartOptions& options, const Made& made, double tolerance)
{
    fmt::print("{} at {} x {} on {}: {} points, {} visit{} each ({} made now), reference to {:g} "
               "{}\n",
               options.input, chart.size.x, chart.size.y, made.device, chart.points.size(),
               chart.rounds, chart.rounds == 1 ? "" : "s", chart.visited, tolerance,
               reference.reused ? "reused" : "in " + duration(reference.seconds));
    fmt::print("{:>3}  {:<52}{:>9}{:>11}{:>11}{:>10}{:>9}\n", "no.",
               fmt::format("the front, by the {}", options.target), "ms", "relMSE", "bias part",
               "variance", "FLIP");
    int number = 0;
    for (const study::MeasuredPoint* p : chart.front())
        print_row(fmt::format("{}", ++number), chart, *p);
    fmt::print("     presets\n");
    for (const study::MeasuredPoint& p : chart.points)
        if (p.point.is_preset && p.refusal.empty())
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

/// By its own estimate: relMSE of a composite that is off by the estimated error everywhere, or
/// where noise is most of that, what it is unsure by once the noise is taken off.
double own_relmse(const study::ReferenceStill& still, bool integrated)
{
    if (!integrated)
        return study::noise_relmse(still.noise, still.composite).deviation;
    std::vector<float> off = still.composite;
    for (std::size_t i = 0; i < off.size(); ++i)
        off[i] += still.error[i / 3];
    return study::compare(off, still.composite).relmse;
}

std::vector<std::pair<std::string, std::string>>
machine_of(const Renderer& renderer, const std::string& reason, const study::Chart& chart,
           const ChartOptions& options, const ChartEffort& effort,
           const study::KeptReference& reference, double reference_relmse)
{
    const gl::Capabilities& gl = renderer.device().capabilities();
    return {{"renderer", gl.renderer},
            {"drawn by", reason},
            {"OpenGL", gl.version},
            {"processor", processor_name()},
            {"system", system_name()},
            {"timing", fmt::format("{}; median over {} visits of {} frames each, after a frame "
                                   "that is not timed, points in shuffled order",
                                   chart.timing_method, chart.rounds, effort.frames)},
            {"errors", fmt::format("pictures of {} seeds, pixel centres; FLIP of the first "
                                   "seed's composite through the filmic transform",
                                   effort.seeds)},
            {"reference",
             fmt::format("{}{}, tolerance {:g} of each pixel, pixel centres; by its own estimate "
                         "{} {:.1e}; {}",
                         chart.once ? "light scatters once" : "all bounces",
                         options.reflections == 0
                             ? ""
                             : fmt::format(", {} of surfaces", bounces_text(options.reflections)),
                         effort.tolerance,
                         options.integrated()
                             ? "its relMSE is"
                             : "the relMSE of its noise, which is taken off each error, is "
                               "known to",
                         reference_relmse, reference.file.filename().string())},
            {"fumarole", fmt::format("{}, compiled by {}", FUMAROLE_VERSION, __VERSION__)}};
}

// ---------------------------------------------------------------------------------- one chart

/// From a scene to the files, step by step.
class ChartRun {
public:
    ChartRun(const ChartOptions& options, const asset::LoadedScene& loaded, fs::path folder)
        : options_{options}, scene_{loaded.scene}, folder_{std::move(folder)}, effort_{effort_of(
                                                                                   options)},
          // Before the reference: a machine without OpenGL says so at once.
          context_{make_context(options.device)}, renderer_{context_->get_proc(), library_log(),
                                                            kept_programs()}
    {
    }

    void run()
    {
        get_reference();
        measure();
        write();
        progress_.clear();
        if (options_.json)
            print_json(chart_, reference_, options_, made_, effort_.tolerance);
        else
            print_table(chart_, reference_, options_, made_, effort_.tolerance);
        if (!made_.plot_failure.empty())
            throw Error(made_.plot_failure);
    }

private:
    /// A kept one, or one to the tolerance for which there is time. A tolerance that was asked for
    /// stays.
    void get_reference()
    {
        study::ReferenceOptions wanted;
        wanted.bounces = options_.once() ? 0 : study::kMeasuredBounces;
        wanted.surface_bounces = options_.reflections;
        wanted.tolerance = effort_.tolerance;
        wanted.cancel = Interruption::flag();
        progress_.show("reference: preparing");
        if (!options_.tolerance && !kept(wanted))
            wanted.tolerance =
                study::fit_tolerance(scene_, wanted, kReferenceShare * effort_.seconds);
        if (wanted.tolerance > effort_.tolerance)
            notes_.push_back(fmt::format(
                "The time limit of {:g} s left no room for a reference to {:g} of each pixel: this "
                "one is to {:g}.",
                effort_.seconds, effort_.tolerance, wanted.tolerance));
        effort_.tolerance = wanted.tolerance;
        wanted.progress = [&](double share) { progress_.show("reference", share); };
        reference_ =
            study::keep_reference(scene_, wanted, folder_, FUMAROLE_VERSION, print_over_progress);
        reference_relmse_ = own_relmse(reference_.still, options_.integrated());
    }

    /// Is there a reference of an earlier run, or a part of one? The closest one's tolerance goes
    /// to `wanted`.
    bool kept(study::ReferenceOptions& wanted) const
    {
        study::ReferenceOptions looser = wanted;
        for (;; looser.tolerance = study::looser(looser.tolerance, looser.most_bounces())) {
            const std::string key = study::reference_key(scene_, looser, FUMAROLE_VERSION);
            const fs::path file = study::kept_reference_file(folder_, key);
            if (fs::exists(file) || fs::exists(study::reference_state_file(file))) {
                wanted.tolerance = looser.tolerance;
                return true;
            }
            if (looser.tolerance >= study::loosest_tolerance(looser.most_bounces()))
                return false;
        }
    }

    void measure()
    {
        study::ChartOptions chosen;
        chosen.quick = options_.quick;
        chosen.shard = parse_shard(options_.shard);
        chosen.once = options_.once();
        chosen.target = parse_target(options_.target);
        chosen.frames = effort_.frames;
        chosen.rounds = effort_.rounds;
        chosen.seeds = effort_.seeds;
        chosen.cancel = Interruption::flag();
        ChartLog log(folder_ / kLogName, study::text_hash(fmt::format(
                                             "{} {} {} {} {} {}", reference_.key, build_hash(),
                                             renderer_.renderer().device().capabilities().renderer,
                                             context_->name(), effort_.frames, effort_.seeds)));
        if (!options_.fresh)
            chosen.known = log.read();
        chosen.keep = [&](const study::ChartVisit& visit) { log.append(visit); };
        chosen.progress = [&](int done, int all, double left) {
            progress_.show(fmt::format("visit {} of {}", std::min(done + 1, all), all),
                           static_cast<double>(done) / std::max(all, 1), left);
        };
        chosen.seconds =
            effort_.seconds * (1 - kWritingShare) - kWritingSeconds - seconds_since(begin_);
        chart_ = study::measure_chart(scene_, reference_.still, renderer_, chosen);
        chart_.limits.insert(chart_.limits.begin(), notes_.begin(), notes_.end());
    }

    void write()
    {
        progress_.show("writing");
        made_.csv = folder_ / "chart.csv";
        write::write_whole(made_.csv, study::chart_csv(chart_));
        study::ReportFacts facts;
        facts.title = fs::path(options_.input).filename().string();
        facts.command = render_command(options_, scene_);
        facts.machine = machine_of(renderer_.renderer(), context_->choice().reason, chart_,
                                   options_, effort_, reference_, reference_relmse_);
        facts.reference_file = reference_.file;
        try {
            study::plot_chart(chart_,
                              fmt::format("{}, {} x {}, {}", facts.title, chart_.size.x,
                                          chart_.size.y, facts.machine.front().second),
                              folder_ / "chart.svg", folder_ / "chart.png");
            made_.svg = folder_ / "chart.svg";
            made_.png = facts.chart_png = folder_ / "chart.png";
        } catch (const Error& error) {
            made_.plot_failure = error.what();
        }
        made_.report = folder_ / "report.html";
        write::write_whole(
            made_.report,
            study::report_html(chart_, facts,
                               study::front_pictures(chart_, scene_, reference_.still, renderer_,
                                                     folder_, Interruption::flag())));
        made_.device = chosen_text(*context_, renderer_.renderer().device());
        made_.device_json = chosen_json(*context_, renderer_.renderer().device());
        made_.seconds = seconds_since(begin_);
    }

    const Clock::time_point begin_ = Clock::now();
    const ChartOptions& options_;
    const Scene& scene_;
    fs::path folder_;
    ChartEffort effort_;
    Progress progress_;
    std::unique_ptr<gl::HeadlessContext> context_;
    SceneRenderer renderer_;
    std::vector<std::string> notes_;  ///< what the time limit took from the reference
    study::KeptReference reference_;
    double reference_relmse_ = 0;
    study::Chart chart_;
    Made made_;
};

void run(ChartOptions options)
{
    parse_surface_bounces(options.surface_bounces, {});  // a mistake is said before loading
    (void)parse_shard(options.shard);
    const asset::LoadedScene loaded =
        load_input({options.input, options.size, options.grid, options.up});
    if (loaded.scene.media.empty())
        throw Error(
            fmt::format("{}: the scene has no media; there is nothing to chart", options.input));
    options.reflections = parse_surface_bounces(options.surface_bounces, loaded.scene);
    const fs::path folder = options.output.empty()
                                ? fs::path(fs::path(options.input).stem().string() + "_chart")
                                : fs::path(options.output);
    make_folder(folder);
    const Interruption interruption;
    try {
        ChartRun(options, loaded, folder).run();
    } catch (const study::ReferenceCancelled& cancelled) {
        throw Error(fmt::format("interrupted with {:.1f} % of the reference's pixels kept; this "
                                "goes on from there: {}",
                                100 * cancelled.kept, continue_command(options)));
    } catch (const study::ChartCancelled&) {
        throw Error(fmt::format("interrupted; {} keeps what was measured, and this goes on from "
                                "there: {}",
                                (folder / kLogName).string(), continue_command(options)));
    }
}

}  // namespace

void add_chart(CLI::App& app)
{
    CLI::App* command = app.add_subcommand(
        "chart", "What each setting costs in time and in error, on this very scene: chart.csv, "
                 "chart.svg, chart.png, report.html");
    auto options = std::make_shared<ChartOptions>();
    ChartOptions& o = *options;
    command->add_option("INPUT", o.input, "a .vdb or .nvdb file, or a scene file (.json)")
        ->required();
    command
        ->add_option("-o,--output", o.output,
                     "where all is written; made if need be [INPUT's name_chart]")
        ->type_name("FOLDER");
    command->add_flag("--quick", o.quick,
                      "fewer points and a coarser reference, for a minute instead of ten");
    command->add_option("--target", o.target, "what the error is of [composite]")
        ->check(CLI::IsMember({"composite", "scattering", "transmittance"}));
    command
        ->add_option(
            "--bounces", o.bounces,
            "of the truth: all, or 0, with which light scatters once in it and in all that "
            "is measured [all]")
        ->check(CLI::IsMember({"0", "all"}));
    command->add_option("--surface-bounces", o.surface_bounces, kSurfaceBouncesHelp)
        ->type_name(kSurfaceBouncesValue);
    add_size_option(*command, o.size);
    add_grid_options(*command, o.grid, o.up);
    command
        ->add_option("--tolerance", o.tolerance,
                     "relative error of the reference's pixels [0.1, with --quick 0.2; with "
                     "--bounces 0 1e-3 and 1e-2]")
        ->type_name("ERROR")
        ->check(within(1e-6, 0.5));
    command
        ->add_option("--time-limit", o.time_limit,
                     "reference, points and visits are cut to fit [600, with --quick 60]")
        ->type_name("SECONDS")
        ->check(within(1.0, 1e6));
    command->add_option("--frames", o.frames, "frames timed at each visit [3, with --quick 2]")
        ->type_name("N")
        ->check(within(1, 1000));
    command->add_flag("--fresh", o.fresh, "measure again what an earlier run measured");
    command
        ->add_option("--shard", o.shard,
                     "a share of the points, as 2/4; all into one folder and with a --tolerance, "
                     "and then once without to merge them [1/1]")
        ->type_name("I/N");
    command->add_flag("--json", o.json, "print JSON");
    add_device_options(*command, o.device);
    command->footer("An interrupted chart goes on where it was; the reference and the points stay "
                    "in the folder.\nExit code: 0 all written, 1 not, 2 wrong command line.");
    command->callback([options] { run(*options); });
}

}  // namespace fumarole::command
