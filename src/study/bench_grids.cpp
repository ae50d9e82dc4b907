#include "study/bench_grids.h"
#include "medium/grid_layout.h"

#include <array>
#include <chrono>
#include <fmt/format.h>
#include <fstream>
#include <memory>

#include "study/bench_scenes.h"
#include <fumarole/errors.h>

namespace fumarole::study {

namespace {

using Clock = std::chrono::steady_clock;

constexpr const char* kGroup = "grids";
constexpr double kMemoryShare = 0.25;
constexpr double kGiB = 1u << 30;
constexpr std::array<const char*, 3> kLayouts{"auto", "bricks", "dense"};

/// Bytes at the worst moment for a grid of n^3 with so many stored voxels: floats of the grid, then
/// the half floats of the larger layout twice, here and in the GL.
double peak_bytes(double edge, double stored)
{
    return 4 * stored + 2 * 2 * std::max(edge * edge * edge, 1.5 * stored);
}

std::vector<BenchCase> layout_cases(const Scene& scene, double stored)
{
    std::vector<BenchCase> cases;
    for (const char* layout : kLayouts) {
        BenchCase made = preset_case({"smoke", scene}, "default", {480, 270});
        made.group = kGroup;
        made.name = layout;
        made.base = layout == kLayouts.front() ? "" : kLayouts.front();
        made.axis = "voxels stored";
        made.at = stored;
        find_setting("layout").set(made.settings, layout);
        cases.push_back(std::move(made));
    }
    return cases;
}

}  // namespace

double free_memory()
{
    std::ifstream file("/proc/meminfo");
    std::string word;
    double kib = 0;
    while (file >> word)
        if (word == "MemAvailable:" && file >> kib)
            return kib * 1024;
    return 0;
}

std::vector<BenchFigure> memory_figures(const VoxelGrid& grid, const std::string& scene)
{
    std::vector<BenchFigure> figures;
    if (grid.empty() || grid.active_voxels == 0)
        return figures;
    const auto active = static_cast<double>(grid.active_voxels);
    // A made smoke is floats, here as in the file that write_plume() makes of it; another program
    // might have written halves, so those are named too.
    const double stored = grid.channels * (grid.stored_as_half ? 2 : 4);
    for (const char* name : kLayouts) {
        Settings settings;
        find_setting("layout").set(settings, name);
        const auto add = [&](const char* quantity, const char* unit, double value) {
            figures.push_back(
                {"memory", scene, name, "", 0, quantity, unit, spread_of({value}), {}});
        };
        try {
            const medium::GridLayout plan =
                medium::plan_layout(grid, settings.layout, settings.storage, {});
            const auto bytes = static_cast<double>(plan.gpu_bytes());
            add("grid on the GPU", "B", bytes);
            add("bytes per active voxel", "B", bytes / active);
            add("bytes of a stored value", "B", stored);
            add("times the stored values", "1", bytes / (active * stored));
            add("times half floats", "1", bytes / (active * grid.channels * 2));
        } catch (const Error&) {  // no such layout for this grid: the sweep says why
            continue;
        }
    }
    return figures;
}

std::vector<BenchFigure> sweep_grids(SceneRenderer& renderer, const BenchOptions& options,
                                     int most_edge, std::vector<std::string>& cuts)
{
    const auto begin = Clock::now();
    const auto seconds = [](Clock::time_point since) {
        return std::chrono::duration<double>(Clock::now() - since).count();
    };
    const double allowed = kMemoryShare * free_memory();
    std::vector<BenchFigure> figures;
    double stored = 0, next_seconds = 0;
    for (int edge = 64; most_edge == 0 || edge <= most_edge; edge *= 2) {
        if (options.cancel != nullptr && *options.cancel)
            break;
        const double needed = peak_bytes(edge, 8 * stored);
        if (needed > allowed) {
            cuts.push_back(fmt::format("grids stop before {}^3: about {:.1f} GiB, more than a "
                                       "quarter of the free memory, {:.1f} GiB",
                                       edge, needed / kGiB, allowed / kGiB));
            break;
        }
        if (seconds(begin) + next_seconds > options.seconds) {
            cuts.push_back(fmt::format("grids stop before {}^3: no time for it", edge));
            break;
        }
        const auto this_begin = Clock::now();
        const auto grid = std::make_shared<const VoxelGrid>(make_plume(edge));
        const double make_ms = 1e3 * seconds(this_begin);
        stored = static_cast<double>(grid->values.size());
        BenchOptions own = options;
        own.seconds = options.seconds - seconds(begin);
        std::vector<BenchFigure> found = case_figures(
            measure_bench(layout_cases(plume_scene(grid), stored), renderer, own, cuts));
        const auto add = [&](const char* quantity, const char* unit, double value) {
            found.push_back({kGroup,
                             "smoke",
                             "grid",
                             "voxels stored",
                             stored,
                             quantity,
                             unit,
                             spread_of({value}),
                             {}});
        };
        add("voxels along an edge", "1", edge);
        add("bricks", "1", static_cast<double>(grid->bricks.size()));
        add("active voxels", "1", static_cast<double>(grid->active_voxels));
        add("made in", "ms", make_ms);
        for (BenchFigure& f : memory_figures(*grid, "smoke")) {
            f.group = kGroup;
            f.axis = "active voxels";
            f.at = static_cast<double>(grid->active_voxels);
            found.push_back(std::move(f));
        }
        figures.insert(figures.end(), found.begin(), found.end());
        // The grid is made and uploaded in eight times as long; its pictures take little longer.
        const double made = make_ms * 1e-3;
        next_seconds = 8 * made + 2 * (seconds(this_begin) - made);
    }
    return figures;
}

}  // namespace fumarole::study
