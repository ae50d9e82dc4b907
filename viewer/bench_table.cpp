#include "bench_table.h"

#include <algorithm>
#include <cstdio>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "progress.h"

namespace fumarole::command {

namespace {

using Json = nlohmann::ordered_json;
using study::BenchFigure;
using study::Spread;

/// `12.1 (11.9 - 13.0)`
std::string cell(const BenchFigure* figure)
{
    if (figure == nullptr)
        return "";
    const Spread& s = figure->value;
    return s.count == 1 && s.min == s.max
               ? fmt::format("{:.4g}", s.median)
               : fmt::format("{:.4g} ({:.3g} - {:.3g})", s.median, s.min, s.max);
}

/// The names of a group's cases in a scene, in order.
std::vector<std::string> names_of(const BenchReport& report, const std::string& group,
                                  const std::string& scene)
{
    std::vector<std::string> names;
    for (const BenchFigure& f : report.figures)
        if (f.group == group && f.scene == scene &&
            std::find(names.begin(), names.end(), f.name) == names.end())
            names.push_back(f.name);
    return names;
}

std::vector<std::string> scenes_of(const BenchReport& report, const std::string& group)
{
    std::vector<std::string> scenes;
    for (const BenchFigure& f : report.figures)
        if (f.group == group && std::find(scenes.begin(), scenes.end(), f.scene) == scenes.end())
            scenes.push_back(f.scene);
    return scenes;
}

void print_cases(const BenchReport& report, const std::string& group, const std::string& base)
{
    const std::vector<std::string> scenes = scenes_of(report, group);
    if (scenes.empty())
        return;
    fmt::print("\n{:<24}{:<26}{:<26}{:>9}{:>9}{:>11}{:>9}\n", group, "ms a frame",
               fmt::format("times faster than {}", base), "texels", "lanes", "relMSE", "MB");
    for (const std::string& scene : scenes) {
        fmt::print("{}\n", scene);
        for (const std::string& name : names_of(report, group, scene)) {
            const auto of = [&](std::string_view quantity) {
                return study::find_figure(report.figures, group, scene, name, quantity);
            };
            const BenchFigure* share = of(study::kMarchShare);
            const BenchFigure* lanes = of(study::kMarchLanes);
            const BenchFigure* error = of(study::kCompositeError);
            const BenchFigure* bytes = of("GPU memory");
            fmt::print("  {:<22}{:<26}{:<26}{:>9}{:>9}{:>11}{:>9}\n", name,
                       cell(of(study::kVolumeTime)),
                       cell(of(std::string(study::kTimesFaster) + base)),
                       share == nullptr ? "" : fmt::format("{:.0f} %", 100 * share->value.median),
                       lanes == nullptr ? "" : fmt::format("{:.0f} %", 100 * lanes->value.median),
                       error == nullptr ? "" : fmt::format("{:.2e}", error->value.median),
                       bytes == nullptr ? "" : fmt::format("{:.1f}", bytes->value.median * 1e-6));
        }
    }
}

void print_growth(const BenchReport& report)
{
    const std::vector<study::GrowthCurve> curves =
        study::growth_curves(report.figures, study::kVolumeTime);
    if (curves.empty())
        return;
    fmt::print("\n{:<14} {:<17} {:<24}{:>20}{:>18}   {}\n", "growth with", "scene", "case",
               "from, to", "ms a frame", "time ~");
    for (const study::GrowthCurve& curve : curves) {
        const auto [low, high] = std::minmax_element(curve.points.begin(), curve.points.end());
        fmt::print("{:<14} {:<17} {:<24}{:>20}{:>18}   x^{:.2f}, or {:.3g} + {:.3g} x ms\n",
                   curve.axis, curve.scene, curve.name,
                   fmt::format("{:.9g}, {:.9g}", low->first, high->first),
                   fmt::format("{:.4g}, {:.4g}", low->second, high->second), curve.growth.exponent,
                   curve.growth.fixed, curve.growth.slope);
    }
}

void print_grids(const BenchReport& report)
{
    for (const char* group : {"grids", "memory"}) {
        const auto is_size = [&](const BenchFigure& f) {
            return f.group == group && f.quantity == "times the stored values";
        };
        if (std::none_of(report.figures.begin(), report.figures.end(), is_size))
            continue;
        fmt::print("\n{:<24}{:<10}{:>16}{:>26}{:>26}{:>20}\n", group, "layout", "active voxels",
                   "bytes per active voxel", "times the stored values", "times half floats");
        for (const BenchFigure& f : report.figures) {
            if (!is_size(f))
                continue;
            const auto of = [&](const char* quantity) {
                return std::find_if(report.figures.begin(), report.figures.end(),
                                    [&](const auto& b) {
                                        return b.group == f.group && b.scene == f.scene &&
                                               b.name == f.name && b.at == f.at &&
                                               b.quantity == quantity;
                                    })
                    ->value.median;
            };
            fmt::print("{:<24}{:<10}{:>16}{:>26.2f}{:>26.2f}{:>20.2f}\n", f.scene, f.name,
                       f.axis.empty() ? "" : fmt::format("{:.0f}", f.at),
                       of("bytes per active voxel"), f.value.median, of("times half floats"));
        }
    }
}

void print_times(const BenchReport& report, const char* group)
{
    for (const std::string& scene : scenes_of(report, group)) {
        fmt::print("\n{:<42}{}\n", fmt::format("{}, {}", group, scene), "ms");
        for (const BenchFigure& f : report.figures)
            if (f.group == group && f.scene == scene)
                fmt::print("  {:<40}{}\n", f.name, cell(&f));
    }
}

}  // namespace

void print_bench_table(const BenchReport& report)
{
    fmt::print("{}\n", report.machine);
    for (const char* name : {"fragments", "compute"})
        if (const BenchFigure* rate = study::find_figure(report.figures, "machine", "", name,
                                                         "trilinear texels a second"))
            fmt::print("trilinear texels, {}: {:.4g} M/s ({:.4g} to {:.4g} in {} looks)\n", name,
                       rate->value.median * 1e-6, rate->value.min * 1e-6, rate->value.max * 1e-6,
                       rate->value.count);
    fmt::print("Figures are medians (least - largest); ratios are taken within a round.\n");
    print_cases(report, "presets", "eevee2017");
    print_cases(report, "passes", "fragment");
    print_cases(report, "ablation", "none");
    print_growth(report);
    print_grids(report);
    print_times(report, "load");
    print_times(report, "programs");
    if (!report.goals.empty())
        fmt::print("\n{:<56}{:>10}\n", "goals", "measured");
    for (const study::BenchGoal& goal : report.goals)
        fmt::print("{:<56}{:>10.4g}   {}\n", goal.text, goal.value,
                   goal.held() ? "held" : "falls short");
    fmt::print("\n");
    for (const std::string& note : report.notes)
        fmt::print("note: {}\n", note);
    for (const std::filesystem::path& file : report.files)
        fmt::print("wrote {}\n", file.string());
    fmt::print("{}\n", duration(report.seconds));
}

void print_bench_json(const BenchReport& report)
{
    Json figures = Json::array(), goals = Json::array(), growth = Json::array(),
         files = Json::array();
    for (const BenchFigure& f : report.figures) {
        Json one{{"group", f.group},         {"scene", f.scene},   {"case", f.name},
                 {"quantity", f.quantity},   {"unit", f.unit},     {"min", f.value.min},
                 {"median", f.value.median}, {"max", f.value.max}, {"count", f.value.count}};
        if (f.size.x > 0)
            one["size"] = {f.size.x, f.size.y};
        if (!f.axis.empty()) {
            one["axis"] = f.axis;
            one["at"] = f.at;
        }
        figures.push_back(std::move(one));
    }
    for (const study::BenchGoal& g : report.goals)
        goals.push_back(
            {{"goal", g.text}, {"measured", g.value}, {"bound", g.bound}, {"held", g.held()}});
    for (const study::GrowthCurve& c : study::growth_curves(report.figures, study::kVolumeTime))
        growth.push_back({{"axis", c.axis},
                          {"scene", c.scene},
                          {"case", c.name},
                          {"exponent", c.growth.exponent},
                          {"fixed_ms", c.growth.fixed},
                          {"ms_per_unit", c.growth.slope}});
    for (const std::filesystem::path& file : report.files)
        files.push_back(file.string());
    Json json{{"machine", report.machine}, {"figures", figures},
              {"growth", growth},          {"goals", goals},
              {"notes", report.notes},     {"outputs", files},
              {"seconds", report.seconds}};
    json.update(report.device);
    fmt::print("{}\n", json.dump(1, ' ', false, Json::error_handler_t::replace));
}

}  // namespace fumarole::command
