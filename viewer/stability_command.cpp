#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <memory>
#include <nlohmann/json.hpp>

#include "command.h"
#include "device_options.h"
#include "kept_programs.h"
#include "library_log.h"
#include "output_folder.h"
#include "progress.h"
#include "shard_option.h"
#include "study/stability.h"
#include "study/stability_held.h"
#include "write/whole_file.h"
#include <fumarole/errors.h>

namespace fumarole::command {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using study::StabilityCase;
using study::StabilityResult;
using study::StabilityRun;

struct StabilityOptions {
    std::string output = "stability", held, shard;
    std::vector<std::string> merge;
    DeviceOptions device;
    study::StabilityChoice choice;
    bool list = false, explain = false, json = false, accept = false;
};

std::string_view sense_of(const StabilityCase& c)
{
    return c.sense == StabilityCase::Bound::at_most ? "<=" : ">=";
}

std::string subject_of(const StabilityRun& run)
{
    return fmt::format("{}/{}", run.subject->mode, run.subject->preset);
}

/// Names of the modes or presets that there are.
std::vector<std::string_view> names(std::string_view study::StabilitySubject::*which)
{
    std::vector<std::string_view> all;
    for (const study::StabilitySubject& subject : study::stability_subjects())
        if (std::find(all.begin(), all.end(), subject.*which) == all.end())
            all.push_back(subject.*which);
    return all;
}

void check_name(std::string_view option, const std::string& name,
                std::string_view study::StabilitySubject::*which)
{
    const std::vector<std::string_view> all = names(which);
    if (!name.empty() && std::find(all.begin(), all.end(), name) == all.end())
        throw UsageError(
            fmt::format("{}: no '{}' (there are: {})", option, name, fmt::join(all, ", ")));
}

std::vector<StabilityRun> chosen_runs(const StabilityOptions& options)
{
    check_name("--mode", options.choice.mode, &study::StabilitySubject::mode);
    check_name("--preset", options.choice.preset, &study::StabilitySubject::preset);
    std::vector<StabilityRun> runs = study::stability_runs(options.choice);
    if (runs.empty())
        throw UsageError(fmt::format("--case: '{}' is in no case's name and no group from 1 to 12 "
                                     "of this choice; --list shows them all",
                                     options.choice.pattern));
    return runs;
}

struct Measured {
    std::vector<StabilityResult> results;
    std::string device;  ///< device, and why it is this one
    Json device_json;
};

/// A heading wherever another group begins.
class Headings {
public:
    void at(const StabilityRun& run)
    {
        if (run.what->group == group_)
            return;
        group_ = run.what->group;
        fmt::print("{:>2}. {}\n", group_,
                   study::kStabilityGroups[static_cast<std::size_t>(group_ - 1)]);
    }

private:
    int group_ = 0;
};

void print_list(const std::vector<StabilityRun>& runs)
{
    Headings headings;
    for (std::size_t i = 0; i < runs.size(); ++i) {
        const StabilityCase& c = *runs[i].what;
        if (i > 0 && runs[i - 1].what == &c)
            continue;
        headings.at(runs[i]);
        fmt::print("    {:<37}{:<8}{} {} {:.4g} {}\n", c.name, c.quick ? "quick" : "", c.shows,
                   sense_of(c), c.bound, c.unit);
    }
}

void print_table(const Measured& measured, bool explain)
{
    fmt::print("on {}\n", measured.device);
    const std::vector<StabilityResult>& results = measured.results;
    Headings headings;
    for (const StabilityResult& r : results) {
        headings.at(r.run);
        const StabilityCase& c = *r.run.what;
        fmt::print("    {:<37}{:<24}{:>10.3g} {} {:<8.3g} {:<17}{}\n", c.name, subject_of(r.run),
                   r.figure.value, sense_of(c), c.bound, c.unit, r.holds ? "holds" : "FALLS SHORT");
        if (!r.refusal.empty())
            fmt::print("        {}\n", r.refusal);
        if (explain)
            fmt::print("        {}\n        bound: {}\n", c.shows, c.reason);
    }
    for (const study::StabilitySubject& subject : study::stability_subjects()) {
        int all = 0, held = 0;
        for (const StabilityResult& r : results)
            if (r.run.subject == &subject) {
                ++all;
                held += r.holds ? 1 : 0;
            }
        if (all > 0)
            fmt::print("{}/{}: {} of {} hold, {} fall short\n", subject.mode, subject.preset, held,
                       all, all - held);
    }
}

/// Pictures of what fell short; those of an earlier run, of what now holds, go.
std::vector<fs::path> write_pictures(const std::vector<StabilityResult>& results,
                                     const fs::path& folder)
{
    std::vector<fs::path> files;
    for (const StabilityResult& r : results) {
        const fs::path file = folder / fmt::format("{}_{}_{}.png", r.run.what->name,
                                                   r.run.subject->mode, r.run.subject->preset);
        if (r.holds || r.figure.pictures.actual.empty()) {
            std::error_code ignored;
            fs::remove(file, ignored);
            continue;
        }
        Display display;
        display.transform = Display::Transform::srgb;
        write::write_png(study::stability_strip(r.figure.pictures), display, file);
        files.push_back(file);
    }
    return files;
}

void print_json(const Measured& measured, const study::HeldChanges& changes,
                const std::vector<fs::path>& files, double seconds)
{
    Json cases = Json::array(), outputs = Json::array();
    for (const StabilityResult& r : measured.results) {
        const StabilityCase& c = *r.run.what;
        Json one{{"group", c.group},
                 {"case", c.name},
                 {"mode", r.run.subject->mode},
                 {"preset", r.run.subject->preset},
                 {"figure", r.figure.value},
                 {"sense", sense_of(c)},
                 {"bound", c.bound},
                 {"unit", c.unit},
                 {"holds", r.holds},
                 {"seconds", r.seconds},
                 {"shows", c.shows},
                 {"reason", c.reason}};
        one["refusal"] = r.refusal.empty() ? Json() : Json(r.refusal);
        cases.push_back(std::move(one));
    }
    for (const fs::path& file : files)
        outputs.push_back(file.string());
    Json json = measured.device_json;
    json.update({{"seconds", seconds},
                 {"cases", cases},
                 {"no_longer_hold", changes.lost},
                 {"worse", changes.worse},
                 {"newly_hold", changes.gained},
                 {"added", changes.added},
                 {"outputs", outputs}});
    fmt::print("{}\n", json.dump(1, ' ', false, Json::error_handler_t::replace));
}

Measured measure(const std::vector<StabilityRun>& runs, const StabilityOptions& options)
{
    const auto context = make_context(options.device);
    SceneRenderer renderer(context->get_proc(), library_log(), kept_programs());
    const gl::Device& device = renderer.renderer().device();
    Measured measured{{}, chosen_text(*context, device), chosen_json(*context, device)};
    Progress progress;
    measured.results =
        study::measure_stability(runs, renderer, options.output,
                                 [&](int done, int all, const StabilityRun& next, double left) {
                                     const std::string what = fmt::format(
                                         "case {} of {}, {}", done + 1, all, next.what->name);
                                     const double share = static_cast<double>(done) / all;
                                     progress.show(what, share, left);
                                 });
    return measured;
}

void print_changes(const study::HeldChanges& changes)
{
    for (const std::string& text : changes.gained)
        fmt::print("newly holds: {}\n", text);
    for (const std::string& text : changes.added)
        fmt::print("not known then: {}\n", text);
}

/// What is worse than in the held file fails the run, or is taken as it is.
void judge(const std::vector<study::HeldCase>& before, const std::vector<StabilityResult>& results,
           const study::HeldChanges& changes, const StabilityOptions& options)
{
    if (options.accept) {
        write::write_whole(options.held, study::accepted_csv(before, results, options.held));
        return;
    }
    std::vector<std::string> lines = changes.lost;
    lines.insert(lines.end(), changes.worse.begin(), changes.worse.end());
    if (!lines.empty())
        throw Error(fmt::format("{} cases no longer hold and {} are worse than in {}; --accept "
                                "takes them as they are now:\n  {}",
                                changes.lost.size(), changes.worse.size(), options.held,
                                fmt::join(lines, "\n  ")));
}

void run(const StabilityOptions& options)
{
    const auto begin = std::chrono::steady_clock::now();
    std::vector<StabilityRun> runs = chosen_runs(options);
    const study::Shard shard = parse_shard(options.shard);
    if (!options.merge.empty()) {
        const std::string csv =
            study::merged_csv(runs, {options.merge.begin(), options.merge.end()});
        make_folder(options.output);
        const fs::path file = fs::path(options.output) / "stability.csv";
        write::write_whole(file, csv);
        fmt::print("wrote {}, {} figures of {} files\n", file.string(), runs.size(),
                   options.merge.size());
        return;
    }
    std::size_t item = 0;
    std::erase_if(runs, [&](const StabilityRun&) { return !shard.has(item++); });
    check_device(options.device);
    if (options.list) {
        print_list(runs);
        return;
    }
    // Before minutes of work: can it be compared, and is there a folder?
    std::vector<study::HeldCase> before;
    if (!options.held.empty())
        before = study::read_held(write::read_whole(options.held), options.held);
    const fs::path folder = options.output;
    make_folder(folder);

    const Measured measured = measure(runs, options);
    const std::vector<StabilityResult>& results = measured.results;
    std::vector<fs::path> files{folder / "stability.csv"};
    write::write_whole(files[0], study::stability_csv(results));
    const std::vector<fs::path> pictures = write_pictures(results, folder);
    files.insert(files.end(), pictures.begin(), pictures.end());
    const study::HeldChanges changes =
        options.held.empty() ? study::HeldChanges{} : study::compare_held(before, results);
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    if (options.json) {
        print_json(measured, changes, files, seconds);
    } else {
        print_table(measured, options.explain);
        print_changes(changes);
        fmt::print("wrote {}{}, in {}\n", files[0].string(),
                   pictures.empty() ? "" : fmt::format(" and {} pictures", pictures.size()),
                   duration(seconds));
    }
    if (!options.held.empty())
        judge(before, results, changes, options);
}

}  // namespace

void add_stability(CLI::App& app)
{
    CLI::App* command = app.add_subcommand(
        "stability", "The method's known failures as cases: a figure, a bound and its reason each, "
                     "for every mode and preset");
    auto options = std::make_shared<StabilityOptions>();
    StabilityOptions& o = *options;
    command
        ->add_option("-o,--output", o.output,
                     "where stability.csv and pictures of what falls short are written; made if "
                     "need be [stability]")
        ->type_name("FOLDER");
    command->add_flag("--quick", o.choice.quick, "fewer cases, under a minute");
    command->add_option("--case", o.choice.pattern, "a group's number, or a part of a case's name")
        ->type_name("N|NAME");
    command->add_option("--mode", o.choice.mode, "one mode alone [all]")->type_name("NAME");
    command
        ->add_option("--preset", o.choice.preset,
                     "one preset alone, or what is asked for by hand, as single [all]")
        ->type_name("NAME");
    command->add_flag("--list", o.list, "say what the cases are, and measure nothing");
    command->add_flag("--explain", o.explain, "say with each figure what it is, and why its bound");
    CLI::Option* held =
        command
            ->add_option("--held", o.held,
                         "an earlier stability.csv: fail if a case that held there no longer does "
                         "or lost half its margin, or if one that fell short is 1.25 times worse")
            ->type_name("FILE.csv")
            ->check(CLI::ExistingFile);
    command
        ->add_flag("--accept", o.accept,
                   "write this run's figures into the file given to --held instead of failing")
        ->needs(held);
    command
        ->add_option("--shard", o.shard,
                     "a share of the cases, as 2/4; each share to a folder of its own, and then "
                     "--merge [1/1]")
        ->type_name("I/N");
    command
        ->add_option("--merge", o.merge,
                     "measure nothing, and make one stability.csv of those that all shards wrote")
        ->type_name("FILE.csv...")
        ->check(CLI::ExistingFile)
        ->excludes(held)
        ->excludes("--shard");
    command->add_flag("--json", o.json, "print JSON");
    add_device_options(*command, o.device);
    command->footer("Cases that fall short are listed, and are no failure of the command.\n"
                    "Exit code: 0 measured, 1 not, or --held was not kept, 2 wrong command line.");
    command->callback([options] { run(*options); });
}

}  // namespace fumarole::command
