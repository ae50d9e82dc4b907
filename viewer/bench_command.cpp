#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fmt/format.h>
#include <memory>
#include <optional>

#include "bench_programs.h"
#include "bench_table.h"
#include "command.h"
#include "device_options.h"
#include "interruption.h"
#include "kept_programs.h"
#include "library_log.h"
#include "machine.h"
#include "output_folder.h"
#include "progress.h"
#include "run_as.h"
#include "scene_input.h"
#include "study/bench_grids.h"
#include "study/bench_load.h"
#include "study/bench_march.h"
#include "study/bench_plot.h"
#include "study/bench_scenes.h"
#include "study/chart.h"
#include "study/reference_cache.h"
#include "study/seconds.h"
#include "study/texel_rate.h"
#include "write/whole_file.h"
#include <fumarole/asset/vdb_file.h>
#include <fumarole/errors.h>
#include <fumarole/scene_renderer.h>

namespace fumarole::command {

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using study::BenchFigure;

constexpr int kPlumeEdge = 128;  ///< voxels of the smoke that is made here

struct BenchOptions {
    std::vector<std::string> inputs, presets;
    std::string output = "bench", group;
    DeviceOptions device;
    std::optional<int> rounds, frames;
    std::optional<double> time_limit;  ///< seconds
    bool quick = false, list = false, errors = false, json = false;
};

/// What a bench may take, and how closely it looks.
struct BenchEffort {
    int rounds, frames;
    int runs;       ///< number of runs of each program, and of each stage of loading
    int most_edge;  ///< longest edge of the grids; 0: as memory allows
    double seconds;
};
constexpr BenchEffort kWholeBench{
    .rounds = 3, .frames = 3, .runs = 5, .most_edge = 0, .seconds = 900};
constexpr BenchEffort kQuickBench{
    .rounds = 2, .frames = 2, .runs = 2, .most_edge = 128, .seconds = 120};

/// Of the time that cases and grids share.
constexpr double kCaseShare = 0.7;

BenchEffort effort_of(const BenchOptions& options)
{
    BenchEffort effort = options.quick ? kQuickBench : kWholeBench;
    effort.rounds = options.rounds.value_or(effort.rounds);
    effort.frames = options.frames.value_or(effort.frames);
    effort.seconds = options.time_limit.value_or(effort.seconds);
    return effort;
}

bool interrupted()
{
    return *Interruption::flag();
}

/// What the user named first, then what is made here.
std::vector<study::BenchScene> make_scenes(const BenchOptions& options,
                                           std::shared_ptr<const VoxelGrid> smoke)
{
    std::vector<study::BenchScene> scenes;
    for (const std::string& input : options.inputs) {
        Scene scene = load_input({input, "", "", "auto"}).scene;
        if (scene.media.empty())
            throw Error(
                fmt::format("{}: the scene has no media; there is nothing to measure", input));
        scenes.push_back({fs::path(input).stem().string(), std::move(scene)});
    }
    scenes.push_back({"smoke", study::plume_scene(std::move(smoke))});
    scenes.push_back({"noise", study::noise_scene()});
    scenes.push_back({"fog", study::fog_scene()});
    scenes.push_back({"haze", study::haze_scene()});
    return scenes;
}

/// A file and a scene that shows it.
struct VdbUse {
    fs::path file;
    const Scene* scene;
    const GridMedium* medium;
};

std::vector<VdbUse> vdbs_of(const std::vector<study::BenchScene>& scenes)
{
    std::vector<VdbUse> uses;
    for (const study::BenchScene& scene : scenes)
        for (const Medium& medium : scene.scene.media) {
            const auto* grid = std::get_if<GridMedium>(&medium);
            if (grid != nullptr && !grid->file.empty() &&
                std::none_of(uses.begin(), uses.end(),
                             [&](const VdbUse& use) { return use.file == grid->file; }))
                uses.push_back({grid->file, &scene.scene, grid});
        }
    return uses;
}

void print_list(const std::vector<study::BenchScene>& scenes, const BenchOptions& options)
{
    for (const study::BenchCase& c :
         study::plan_bench(scenes, options.presets, options.group, options.quick))
        fmt::print("{}\n", c.text());
    const auto other = [&](std::string_view group, const char* text) {
        if (options.group.empty() || options.group == group)
            fmt::print("{}: {}\n", group, text);
    };
    other("grids", "smoke in 64^3 voxels, 128^3, ... in each layout");
    other("load", "each .vdb, stage by stage");
    other("programs", "fumarole render and vdb_render on each .vdb, from start to end");
}

/// From scenes to the files, step by step.
class BenchRun {
public:
    explicit BenchRun(const BenchOptions& options)
        : options_{options}, folder_{options.output}, effort_{effort_of(options)},
          context_{make_context(options.device)}, renderer_{context_->get_proc(), library_log(),
                                                            kept_programs()},
          drawn_rate_{device(), false}, computed_rate_{device(), true}
    {
    }

    void run()
    {
        make_input();
        look_at_machine(false);
        look_at_machine(true);
        measure_programs();
        measure_loading();
        measure_cases();
        measure_grids();
        look_at_machine(false);
        look_at_machine(true);
        finish_rates();
        measure_errors();
        write();
        progress_.clear();
        if (options_.json)
            print_bench_json(report_);
        else
            print_bench_table(report_);
        if (!plot_failure_.empty())
            throw Error(plot_failure_);
        if (interrupted())
            throw Error(fmt::format("interrupted; {} holds what was measured until then",
                                    (folder_ / "bench.csv").string()));
    }

private:
    [[nodiscard]] bool wanted(std::string_view group) const
    {
        return (options_.group.empty() || options_.group == group) && !interrupted();
    }
    [[nodiscard]] double seconds_left() const
    {
        return std::max(1.0, effort_.seconds - study::seconds_since(begin_));
    }
    const gl::Device& device() { return renderer_.renderer().device(); }
    double look_at_machine(bool computes)
    {
        std::vector<double>& rates = computes ? computed_rates_ : drawn_rates_;
        rates.push_back((computes ? computed_rate_ : drawn_rate_).measure());
        return rates.back();
    }
    void add(std::vector<BenchFigure> figures)
    {
        std::move(figures.begin(), figures.end(), std::back_inserter(report_.figures));
    }

    void make_input()
    {
        const fs::path file = folder_ / "smoke.vdb";
        study::write_plume(study::make_plume(kPlumeEdge), file);
        report_.scenes = make_scenes(
            options_, std::make_shared<const VoxelGrid>(asset::load_grid(file, "").grid));
        for (study::BenchScene& scene : report_.scenes)
            for (Medium& medium : scene.scene.media)
                if (auto* grid = std::get_if<GridMedium>(&medium); grid && grid->file.empty())
                    grid->file = file.string();
        for (const VdbUse& use : vdbs_of(report_.scenes))
            add(study::memory_figures(*use.medium->density, use.file.filename().string()));
    }

    void measure_programs()
    {
        if (!wanted("programs"))
            return;
        progress_.show("whole programs");
        for (const VdbUse& use : vdbs_of(report_.scenes))
            if (wanted("programs"))
                add(program_figures(use.file, *use.scene, device_words(options_.device), folder_,
                                    effort_.runs, report_.notes));
    }

    void measure_loading()
    {
        for (const VdbUse& use : vdbs_of(report_.scenes))
            if (wanted("load")) {
                progress_.show("loading " + use.file.filename().string());
                add(study::load_figures(use.file, context_->get_proc(), effort_.runs));
            }
    }

    [[nodiscard]] study::BenchOptions bench_options(double seconds)
    {
        study::BenchOptions bench;
        bench.rounds = effort_.rounds;
        bench.frames = effort_.frames;
        bench.seconds = seconds;
        bench.machine_rate = [this](const Settings& settings) {
            return look_at_machine(runs_compute(device(), settings));
        };
        bench.progress = [this](const std::string& what, double share) {
            progress_.show(what, share);
        };
        bench.cancel = Interruption::flag();
        return bench;
    }

    void measure_cases()
    {
        if (interrupted())
            return;
        std::vector<study::BenchCase> cases =
            study::plan_bench(report_.scenes, options_.presets, options_.group, options_.quick);
        const double end =
            study::seconds_since(begin_) + (wanted("grids") ? kCaseShare : 1) * seconds_left();
        // What is compared gets all its rounds before a picture of 4K takes their time.
        const auto growth =
            std::stable_partition(cases.begin(), cases.end(), [](const study::BenchCase& one) {
                return one.group == "presets" || one.group == "ablation";
            });
        for (const auto& [first, last] :
             {std::pair{cases.begin(), growth}, {growth, cases.end()}}) {
            std::vector<study::MeasuredCase> found = study::measure_bench(
                {first, last}, renderer_,
                bench_options(std::max(1.0, end - study::seconds_since(begin_))), report_.notes);
            std::move(found.begin(), found.end(), std::back_inserter(measured_));
        }
        add(study::case_figures(measured_));
    }

    void measure_grids()
    {
        if (wanted("grids"))
            add(study::sweep_grids(renderer_, bench_options(seconds_left()), effort_.most_edge,
                                   report_.notes));
    }

    /// The machine's own rates, and what of them each march reaches: of that of its own kind.
    void finish_rates()
    {
        for (const auto& [name, rates] :
             {std::pair{"fragments", &drawn_rates_}, {"compute", &computed_rates_}})
            report_.figures.push_back({"machine",
                                       "",
                                       name,
                                       "",
                                       0,
                                       "trilinear texels a second",
                                       "1/s",
                                       study::spread_of(*rates),
                                       {}});
        for (const study::MeasuredCase& one : measured_) {
            const study::BenchCase& c = one.bench_case;
            if ((c.group != "presets" && c.group != "passes") || one.volume.empty() ||
                interrupted())
                continue;
            const auto row = [&](std::string_view quantity, const char* unit,
                                 const study::Spread& value) {
                report_.figures.push_back({c.group, c.scene_name, c.name, "", 0,
                                           std::string(quantity), unit, value, c.scene.resolution});
            };
            if (one.even_4 > 0) {
                row(study::kMarchLanes, "1", study::spread_of({one.even_4}));
                row("march, lanes at work of 8 x 8 rays", "1", study::spread_of({one.even_8}));
            }
            progress_.show("counting fetches");
            const double fetches = study::count_march_fetches(renderer_, c.scene, c.settings).all();
            const auto [rate, share] = study::fetch_rates(one, "ray march", fetches);
            if (fetches > 0 && one.samples > 0)
                row("march, texels an evaluation", "1", study::spread_of({fetches / one.samples}));
            if (fetches == 0 || share.count == 0)
                continue;
            row("march, texels of a frame", "1", study::spread_of({fetches}));
            row(study::kMarchRate, "1/s", rate);
            row(study::kMarchShare, "1", share);
        }
    }

    /// What the presets' pictures are off by, where asked for: a reference takes minutes.
    void measure_errors()
    {
        if (!options_.errors || !wanted("presets"))
            return;
        try {
            for (const study::BenchScene& scene : report_.scenes)
                measure_errors(scene);
        } catch (const study::ReferenceCancelled&) {
            report_.notes.emplace_back("interrupted while a reference was rendered; the same "
                                       "command line goes on with it");
        }
    }

    void measure_errors(const study::BenchScene& scene)
    {
        Scene sized = scene.scene;
        sized.resolution = {480, 270};
        study::ReferenceOptions wanted_reference;
        wanted_reference.bounces = study::kMeasuredBounces;
        wanted_reference.surface_bounces = study::measured_surface_bounces(sized);
        wanted_reference.tolerance = study::usual_tolerance(wanted_reference.most_bounces());
        wanted_reference.cancel = Interruption::flag();
        wanted_reference.progress = [&](double share) {
            progress_.show("reference of " + scene.name, share);
        };
        const study::KeptReference reference = study::keep_reference(
            sized, wanted_reference, folder_, FUMAROLE_VERSION, print_over_progress);
        for (const study::ChartPoint& point : study::chart_points(true)) {
            if (!point.is_preset || study::find_figure(report_.figures, "presets", scene.name,
                                                       point.preset, study::kVolumeTime) == nullptr)
                continue;
            const Still still = study::render_point(renderer_, sized, point);
            report_.figures.push_back(
                {"presets", scene.name, point.preset, "", 0, std::string(study::kCompositeError),
                 "1",
                 study::spread_of(
                     {study::noise_relmse(reference.still.noise, reference.still.composite)
                          .off(study::compare(still.composite, reference.still.composite).relmse)}),
                 sized.resolution});
        }
    }

    void write()
    {
        progress_.show("writing");
        const gl::Capabilities& gl = renderer_.renderer().device().capabilities();
        report_.machine = fmt::format(
            "{}; {}; {}; {} rounds of {} frames, 480 x 270 unless said",
            chosen_text(*context_, renderer_.renderer().device()), processor_name(),
            timing_name(renderer_.renderer().measuring_timing()), effort_.rounds, effort_.frames);
        report_.device = chosen_json(*context_, renderer_.renderer().device());
        report_.goals = study::bench_goals(report_.figures, report_.scenes);
        report_.files = {folder_ / "bench.csv"};
        write::write_whole(report_.files.front(), study::bench_csv(report_.figures));
        try {
            if (study::plot_bench(report_.figures,
                                  fmt::format("{}, {}", gl.renderer, processor_name()),
                                  folder_ / "bench.png"))
                report_.files.push_back(folder_ / "bench.png");
        } catch (const Error& error) {
            plot_failure_ = error.what();
        }
        report_.seconds = study::seconds_since(begin_);
    }

    const Clock::time_point begin_ = Clock::now();
    const BenchOptions& options_;
    fs::path folder_;
    BenchEffort effort_;
    Progress progress_;
    std::unique_ptr<gl::HeadlessContext> context_;
    SceneRenderer renderer_;
    study::TexelRate drawn_rate_, computed_rate_;
    std::vector<double> drawn_rates_, computed_rates_;
    std::vector<study::MeasuredCase> measured_;
    BenchReport report_;
    std::string plot_failure_;
};

void run(const BenchOptions& options)
{
    if (options.list) {
        print_list(make_scenes(options, std::make_shared<const VoxelGrid>()), options);
        return;
    }
    for (const std::string& input : options.inputs)
        if (!fs::exists(input))  // before the folder is made
            throw Error(fmt::format("{}: no such file", input));
    make_folder(options.output);
    const Interruption interruption;
    BenchRun(options).run();
}

}  // namespace

void add_bench(CLI::App& app)
{
    CLI::App* command = app.add_subcommand(
        "bench", "How fast: presets, steps, lights, sizes, grids, loading, in one run, against "
                 "the machine's own texel rate: bench.csv, bench.png");
    auto options = std::make_shared<BenchOptions>();
    BenchOptions& o = *options;
    command->add_option("SCENE", o.inputs,
                        "scene files or .vdb files, besides the scenes made here");
    command->add_option("-o,--output", o.output, "where all is written; made if need be [bench]")
        ->type_name("FOLDER");
    command->add_flag("--quick", o.quick, "fewer cases, rounds and frames: two minutes");
    std::vector<std::string> groups;
    for (const std::string_view group : study::bench_groups())
        groups.emplace_back(group);
    command->add_option("--group", o.group, "one group of cases alone [all]")
        ->type_name("GROUP")
        ->check(CLI::IsMember(groups));
    std::vector<std::string> presets;
    for (const auto& [name, settings] : fumarole::presets())
        presets.emplace_back(name);
    command->add_option("--preset", o.presets, "these alone, with commas between [all]")
        ->type_name("PRESET,...")
        ->delimiter(',')
        ->check(CLI::IsMember(presets));
    command->add_flag("--list", o.list, "say what the cases are, and measure nothing");
    command
        ->add_option("--time-limit", o.time_limit,
                     "without --errors; what does not fit is named [900, with --quick 120]")
        ->type_name("SECONDS")
        ->check(within(1.0, 1e6));
    command->add_option("--rounds", o.rounds, "visits to each case, in turn [3, with --quick 2]")
        ->type_name("N")
        ->check(within(1, 1000));
    command->add_option("--frames", o.frames, "frames timed at each visit [3, with --quick 2]")
        ->type_name("N")
        ->check(within(1, 1000));
    command->add_flag(
        "--errors", o.errors,
        "the presets' errors too, against references with all bounces, which take minutes and "
        "stay in the folder");
    command->add_flag("--json", o.json, "print JSON");
    add_device_options(*command, o.device);
    command->footer("Interrupted, it writes what was measured until then.\n"
                    "Exit code: 0 all written, 1 not, 2 wrong command line.");
    command->callback([options] { run(*options); });
}

}  // namespace fumarole::command
