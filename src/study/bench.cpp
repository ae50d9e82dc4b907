#include "study/bench.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <optional>

#include "study/bench_scenes.h"
#include "study/chart.h"
#include "study/flag_names.h"
#include "study/seconds.h"
#include <fumarole/errors.h>

namespace fumarole::study {

namespace {

using Clock = std::chrono::steady_clock;

constexpr glm::uvec2 kSize{480, 270};
constexpr std::string_view kBase = "eevee2017";

/// Of all the time that is left for cases, at most so much for one visit that nobody asked for.
constexpr double kVisitShare = 1.0 / 6;
/// A visit that is expected to take longer [s] times no more frames than these. Froxels keep a
/// history from two on.
constexpr double kLongVisit = 8;
constexpr int kLongFrames = 2;

struct Cancelled {};

BenchCase make_case(const char* group, const BenchScene& scene, std::string name,
                    const Settings& settings)
{
    BenchCase made;
    made.group = group;
    made.name = std::move(name);
    made.scene_name = scene.name;
    made.scene = scene.scene;
    made.scene.resolution = kSize;
    made.settings = settings;
    return made;
}

Settings with(Settings settings, std::string_view setting, std::string_view value)
{
    find_setting(setting).set(settings, value);
    return settings;
}

/// The scenes that growth is shown on: see plan_bench.
std::vector<const BenchScene*> focus_scenes(std::span<const BenchScene> scenes, bool quick)
{
    const auto has_grid = [](const BenchScene& s) {
        return std::any_of(s.scene.media.begin(), s.scene.media.end(),
                           [](const Medium& m) { return std::holds_alternative<GridMedium>(m); });
    };
    std::vector<const BenchScene*> focus;
    const auto add = [&](const auto& fits) {
        if (const auto at = std::find_if(scenes.begin(), scenes.end(), fits); at != scenes.end())
            focus.push_back(&*at);
    };
    add(has_grid);
    if (!quick || focus.empty())
        add([](const BenchScene& s) { return !is_marched(s.scene); });
    return focus;
}

/// The same pictures by fragments and by compute shaders.
void plan_passes(const BenchScene& scene, std::vector<BenchCase>& cases)
{
    for (const char* preset : {"default", "froxel"})
        for (const char* passes : {"fragment", "compute"}) {
            BenchCase made = preset_case(scene, preset, kSize);
            made.group = "passes";
            made.name = passes;
            made.base = passes == std::string_view("compute") ? "fragment" : "";
            made.scene_name = fmt::format("{}, {}", scene.name, preset);
            made.settings = with(made.settings, "passes", passes);
            cases.push_back(std::move(made));
        }
}

void plan_ablation(const BenchScene& scene, std::vector<BenchCase>& cases)
{
    const Settings all = find_preset("default");
    Settings none = all;
    for (const AblatedStep& step : ablated_steps())
        none = with(none, step.setting, step.off);
    const auto add = [&](std::string name, const Settings& settings) {
        cases.push_back(make_case("ablation", scene, std::move(name), settings));
        cases.back().base = "none";
    };
    add("none", none);
    cases.back().base.clear();
    for (const AblatedStep& step : ablated_steps())
        add(fmt::format("{} alone", step.setting),
            with(none, step.setting, find_setting(step.setting).get(all)));
    for (const AblatedStep& step : ablated_steps())
        add(fmt::format("all but {}", step.setting), with(all, step.setting, step.off));
    add("all", all);
}

void plan_steps(const BenchScene& scene, bool quick, std::vector<BenchCase>& cases)
{
    const auto add = [&](const char* axis, std::string_view setting, int value, std::string name,
                         const Settings& from) {
        cases.push_back(make_case("steps", scene, std::move(name),
                                  with(from, setting, fmt::format("{}", value))));
        cases.back().axis = axis;
        cases.back().at = value;
    };
    const Settings usual = find_preset("default");
    for (const int steps : quick ? std::vector{16, 64, 256} : std::vector{16, 32, 64, 128, 256})
        add("steps", "steps", steps, "default", usual);
    for (const int steps : quick ? std::vector<int>{} : std::vector{4, 16, 64})
        add("shadow steps", "shadow-steps", steps, "default, shadows marched",
            with(usual, "shadow-volume-size", "0"));
}

void plan_lights(const BenchScene& scene, bool quick, std::vector<BenchCase>& cases)
{
    for (const int lights : quick ? std::vector{1, 4} : std::vector{1, 2, 4, 8, 16}) {
        cases.push_back(make_case("lights", {scene.name, with_lights(scene.scene, lights)},
                                  "default", find_preset("default")));
        cases.back().axis = "lights";
        cases.back().at = lights;
    }
}

void plan_sizes(const BenchScene& scene, const std::vector<std::string>& presets, bool quick,
                std::vector<BenchCase>& cases)
{
    for (const unsigned scale : quick ? std::vector{1u, 2u} : std::vector{1u, 2u, 4u, 8u})
        for (const std::string& preset : presets) {
            BenchCase made = preset_case(scene, preset, kSize * scale);
            made.group = "sizes";
            made.axis = "pixels";
            made.at = static_cast<double>(made.scene.resolution.x) * made.scene.resolution.y;
            cases.push_back(std::move(made));
        }
}

Spread merge(const std::vector<PassTime>& visits)
{
    std::vector<double> medians;
    Spread merged;
    for (const PassTime& visit : visits) {
        merged.min = medians.empty() ? visit.min_ms : std::min(merged.min, visit.min_ms);
        merged.max = std::max(merged.max, visit.max_ms);
        medians.push_back(visit.median_ms);
    }
    merged.median = spread_of(medians).median;
    merged.count = static_cast<int>(visits.size());
    return merged;
}

/// Goes round the cases.
class Rounds {
public:
    Rounds(std::vector<BenchCase> cases, SceneRenderer& renderer, const BenchOptions& options)
        : renderer_{renderer}, options_{options}
    {
        for (BenchCase& one : cases) {
            measured_.emplace_back();
            measured_.back().bench_case = std::move(one);
        }
    }

    void go()
    {
        for (int round = 0; round < options_.rounds; ++round)
            for (std::size_t i = 0; i < measured_.size(); ++i) {
                MeasuredCase& one = measured_[i];
                if (!one.refusal.empty() || (round > 0 && one.volume.empty()))
                    continue;
                const double guess = round > 0 ? one.seconds : first_guess(one.bench_case);
                const double left = options_.seconds - seconds_since(begin_);
                if (guess >= left || guess > kVisitShare * options_.seconds)
                    continue;
                tell(one.bench_case, round, i);
                visit(one, round,
                      guess > kLongVisit ? std::min(kLongFrames, options_.frames)
                                         : options_.frames);
            }
    }

    std::vector<MeasuredCase> take() { return std::move(measured_); }

private:
    [[nodiscard]] double watch(const Settings& settings) const
    {
        return options_.machine_rate ? options_.machine_rate(settings) : 0;
    }

    void tell(const BenchCase& one, int round, std::size_t i) const
    {
        if (options_.progress)
            options_.progress(
                fmt::format("round {}, {}", round + 1, one.group),
                (round + static_cast<double>(i) / static_cast<double>(measured_.size())) /
                    options_.rounds);
    }

    void visit(MeasuredCase& one, int round, int frames)
    {
        const auto begin = Clock::now();
        const StillOptions still{
            .timed_frames = frames, .picture = false, .progress = [this](int, int) {
                if (options_.cancel != nullptr && *options_.cancel)
                    throw Cancelled();
            }};
        try {
            StillReport report;
            const double machine = watch(one.bench_case.settings);
            renderer_.render(one.bench_case.scene, one.bench_case.settings, still, &report);
            one.volume.emplace_back(round, report.volume);
            one.passes.push_back(report.passes);
            one.machine.push_back(machine);
            one.samples = report.samples;
            one.even_4 = report.even_4;
            one.even_8 = report.even_8;
            one.gpu_bytes = report.gpu_bytes;
            if (round == 0)
                one.setup_ms = report.setup_ms;
        } catch (const Error& error) {
            one.refusal = with_flags(error.what());
        }
        one.seconds = std::max(one.seconds, seconds_since(begin));
    }

    /// Seconds, from the case before on its curve, which grow as the axis at most; 0: nobody knows.
    [[nodiscard]] double first_guess(const BenchCase& wanted) const
    {
        double guess = 0;
        for (const MeasuredCase& one : measured_) {
            const BenchCase& c = one.bench_case;
            if (one.seconds > 0 && !wanted.axis.empty() && c.group == wanted.group &&
                c.scene_name == wanted.scene_name && c.name == wanted.name && c.axis == wanted.axis)
                guess = one.seconds * std::max(1.0, wanted.at / c.at);
        }
        return guess;
    }

    SceneRenderer& renderer_;
    const BenchOptions& options_;
    const Clock::time_point begin_ = Clock::now();
    std::vector<MeasuredCase> measured_;
};

}  // namespace

// ------------------------------------------------------------------------------------- the plan

std::span<const AblatedStep> ablated_steps()
{
    static constexpr std::array kSteps{
        AblatedStep{"shadow-volume-size", "0"}, AblatedStep{"empty-space-skipping", "off"},
        AblatedStep{"step-spacing", "fixed"},   AblatedStep{"falloff", "sampled"},
        AblatedStep{"resolve-passes", "2"},     AblatedStep{"targets", "two"},
        AblatedStep{"upsample", "4x4"},         AblatedStep{"resolution", "half"},
    };
    return kSteps;
}

std::span<const std::string_view> bench_groups()
{
    static constexpr std::array<std::string_view, 9> kGroups{
        "presets", "passes", "ablation", "steps", "lights", "sizes", "grids", "load", "programs"};
    return kGroups;
}

std::string BenchCase::short_text() const
{
    return axis.empty() ? name : fmt::format("{} at {:.0f} {}", name, at, axis);
}

std::string BenchCase::text() const
{
    return fmt::format("{}, {}: {}", group, scene_name, short_text());
}

/// Whether light is marched through a medium of it: grids and noise have no closed form.
bool is_marched(const Scene& scene)
{
    return std::any_of(scene.media.begin(), scene.media.end(), [](const Medium& medium) {
        const auto* box = std::get_if<BoxMedium>(&medium);
        return box == nullptr || std::holds_alternative<NoiseProfile>(box->profile);
    });
}

BenchCase preset_case(const BenchScene& scene, const std::string& preset, glm::uvec2 size)
{
    BenchCase made = make_case("presets", scene, preset, find_preset(preset));
    made.scene.resolution = size;
    if (preset != kBase)
        made.base = kBase;
    return made;
}

std::vector<BenchCase> plan_bench(std::span<const BenchScene> scenes,
                                  std::span<const std::string> presets, const std::string& group,
                                  bool quick)
{
    std::vector<std::string> names(presets.begin(), presets.end());
    if (names.empty())
        for (const auto& [name, settings] : fumarole::presets())
            names.emplace_back(name);
    std::vector<BenchCase> cases;
    for (const BenchScene& scene : scenes)
        for (const std::string& preset : names)
            cases.push_back(preset_case(scene, preset, kSize));
    const std::vector<const BenchScene*> focus = focus_scenes(scenes, quick);
    for (const BenchScene* scene : focus)
        plan_passes(*scene, cases);
    for (const BenchScene* scene : focus)
        plan_ablation(*scene, cases);
    for (const BenchScene* scene : focus)
        plan_steps(*scene, quick, cases);
    for (const BenchScene* scene : focus)
        plan_lights(*scene, quick, cases);
    for (const BenchScene* scene : focus)
        plan_sizes(*scene, names, quick, cases);
    std::erase_if(cases, [&](const BenchCase& c) { return !group.empty() && c.group != group; });
    return cases;
}

// ---------------------------------------------------------------------------------- measurement

std::vector<MeasuredCase> measure_bench(std::vector<BenchCase> cases, SceneRenderer& renderer,
                                        const BenchOptions& options, std::vector<std::string>& cuts)
{
    Rounds rounds(std::move(cases), renderer, options);
    try {
        rounds.go();
    } catch (const Cancelled&) {
        cuts.emplace_back("interrupted: what was to come is not in the tables");
    }
    std::vector<MeasuredCase> measured = rounds.take();
    std::map<std::string, std::string> none_of;  // by group and scene
    std::map<std::size_t, int> short_of;
    for (const MeasuredCase& one : measured) {
        if (!one.refusal.empty())
            cuts.push_back(fmt::format("{}: {}", one.bench_case.text(), one.refusal));
        else if (one.volume.empty())
            none_of[fmt::format("{}, {}", one.bench_case.group, one.bench_case.scene_name)] +=
                (one.bench_case.short_text() + "; ");
        else if (one.volume.size() < static_cast<std::size_t>(options.rounds))
            ++short_of[one.volume.size()];
    }
    for (const auto& [where, names] : none_of)
        cuts.push_back(fmt::format("no time for {}: {}", where, names.substr(0, names.size() - 2)));
    for (const auto& [rounds_made, count] : short_of)
        cuts.push_back(fmt::format("{} cases were visited {} of {} times, for want of time", count,
                                   rounds_made, options.rounds));
    return measured;
}

// -------------------------------------------------------------------------------------- figures

Spread spread_of(const std::vector<double>& values)
{
    const PassTime summary = summarize("", values);
    return {summary.min_ms, summary.median_ms, summary.max_ms, static_cast<int>(values.size())};
}

std::vector<BenchFigure> case_figures(std::span<const MeasuredCase> cases)
{
    std::vector<BenchFigure> figures;
    for (const MeasuredCase& one : cases) {
        if (one.volume.empty())
            continue;
        const BenchCase& c = one.bench_case;
        const auto add = [&](std::string quantity, const char* unit, const Spread& value) {
            figures.push_back({c.group, c.scene_name, c.name, c.axis, c.at, std::move(quantity),
                               unit, value, c.scene.resolution});
        };
        std::vector<PassTime> volume;
        for (const auto& [round, time] : one.volume)
            volume.push_back(time);
        add(std::string(kVolumeTime), "ms", merge(volume));
        for (const PassTime& first : one.passes.front()) {
            std::vector<PassTime> visits;
            for (const std::vector<PassTime>& passes : one.passes)
                for (const PassTime& pass : passes)
                    if (pass.name == first.name)
                        visits.push_back(pass);
            add("pass " + first.name, "ms", merge(visits));
        }
        add("media evaluations", "1", spread_of({one.samples}));
        add("GPU memory", "B", spread_of({static_cast<double>(one.gpu_bytes)}));
        add("set-up", "ms", spread_of({one.setup_ms}));

        const auto base = std::find_if(cases.begin(), cases.end(), [&](const MeasuredCase& other) {
            return other.bench_case.same_place(c) && other.bench_case.name == c.base;
        });
        if (base == cases.end() || c.base.empty())
            continue;
        std::vector<double> ratios;  // within a round the machine drifts least
        for (const auto& [round, time] : one.volume)
            for (const auto& [base_round, base_time] : base->volume)
                if (round == base_round && time.median_ms > 0)
                    ratios.push_back(base_time.median_ms / time.median_ms);
        if (!ratios.empty())
            add(std::string(kTimesFaster) + c.base, "1", spread_of(ratios));
    }
    return figures;
}

Growth fit_growth(std::span<const std::pair<double, double>> points)
{
    // Two straight lines by least squares: through the logarithms, and through the points, each
    // weighted by 1 / y^2.
    struct Line {
        double w = 0, x = 0, y = 0, xx = 0, xy = 0;
        void add(double weight, double px, double py)
        {
            w += weight;
            x += weight * px;
            y += weight * py;
            xx += weight * px * px;
            xy += weight * px * py;
        }
        [[nodiscard]] double slope() const { return (w * xy - x * y) / (w * xx - x * x); }
        [[nodiscard]] double fixed() const { return (y - slope() * x) / w; }
    } logs, plain;
    for (const auto& [x, y] : points) {
        logs.add(1, std::log(x), std::log(y));
        plain.add(1 / (y * y), x, y);
    }
    return {logs.slope(), plain.fixed(), plain.slope()};
}

std::vector<GrowthCurve> growth_curves(std::span<const BenchFigure> figures,
                                       std::string_view quantity)
{
    std::vector<GrowthCurve> curves;
    for (const BenchFigure& f : figures) {
        if (f.quantity != quantity || f.axis.empty() || f.at <= 0 || f.value.median <= 0)
            continue;
        auto at = std::find_if(curves.begin(), curves.end(), [&](const GrowthCurve& c) {
            return c.group == f.group && c.scene == f.scene && c.name == f.name && c.axis == f.axis;
        });
        if (at == curves.end())
            at = curves.insert(curves.end(), {f.group, f.scene, f.name, f.axis, {}, {}});
        at->points.emplace_back(f.at, f.value.median);
    }
    std::erase_if(curves, [](const GrowthCurve& c) {
        const auto [low, high] = std::minmax_element(c.points.begin(), c.points.end());
        return low->first == high->first;
    });
    for (GrowthCurve& curve : curves)
        curve.growth = fit_growth(curve.points);
    return curves;
}

std::pair<Spread, Spread> fetch_rates(const MeasuredCase& measured, std::string_view pass,
                                      double fetches)
{
    std::vector<double> rates, shares;
    for (std::size_t visit = 0; visit < measured.passes.size(); ++visit)
        for (const PassTime& time : measured.passes[visit])
            if (time.name == pass && time.median_ms > 0) {
                rates.push_back(1e3 * fetches / time.median_ms);
                if (measured.machine[visit] > 0)
                    shares.push_back(rates.back() / measured.machine[visit]);
            }
    return {spread_of(rates), spread_of(shares)};
}

const BenchFigure* find_figure(std::span<const BenchFigure> figures, std::string_view group,
                               std::string_view scene, std::string_view name,
                               std::string_view quantity)
{
    const auto at = std::find_if(figures.begin(), figures.end(), [&](const BenchFigure& f) {
        return f.group == group && f.scene == scene && f.name == name && f.quantity == quantity;
    });
    return at == figures.end() ? nullptr : &*at;
}

std::string bench_csv(std::span<const BenchFigure> figures)
{
    std::string csv =
        "group,scene,case,width,height,axis,at,quantity,unit,min,median,max,count\r\n";
    for (const BenchFigure& f : figures) {
        for (const std::string& text : {f.group, f.scene, f.name})
            csv += csv_field(text) + ',';
        csv += f.size.x > 0 ? fmt::format("{},{},", f.size.x, f.size.y) : ",,";
        csv += csv_field(f.axis) + ',';
        csv += f.axis.empty() ? "," : fmt::format("{:.10g},", f.at);
        csv +=
            fmt::format("{},{},{:.6g},{:.6g},{:.6g},{}\r\n", csv_field(f.quantity),
                        csv_field(f.unit), f.value.min, f.value.median, f.value.max, f.value.count);
    }
    return csv;
}

}  // namespace fumarole::study
