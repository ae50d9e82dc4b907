#include "study/bench_load.h"
#include "medium/grid_layout.h"

#include <algorithm>
#include <chrono>
#include <memory>

#include "asset/vdb_layout.h"
#include <fumarole/asset/auto_scene.h>
#include <fumarole/asset/vdb_file.h>

namespace fumarole::study {

namespace {

/// Milliseconds that a call takes.
template <typename Call> double time(const Call& call)
{
    const auto begin = std::chrono::steady_clock::now();
    call();
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
        .count();
}

/// When each frame of a render began.
class FrameClock {
public:
    void tick() { ticks_.push_back(std::chrono::steady_clock::now()); }
    [[nodiscard]] double ms(std::size_t frame) const
    {
        return std::chrono::duration<double, std::milli>(ticks_[frame + 1] - ticks_[frame]).count();
    }

private:
    std::vector<std::chrono::steady_clock::time_point> ticks_;
};

using Stages = std::vector<std::pair<const char*, double>>;

Stages load_once(const std::filesystem::path& vdb, gl::GetProc get_proc)
{
    Stages stages;
    const auto add = [&](const char* stage, double ms) {
        stages.emplace_back(stage, std::max(0.0, ms));  // a difference may come out below
    };
    const double check = time([&] { asset::read_vdb_layout(vdb); });
    add("read and check the file", check);
    std::shared_ptr<const VoxelGrid> grid;
    add("OpenVDB's tree to bricks",
        time([&] { grid = std::make_shared<const VoxelGrid>(asset::load_grid(vdb, "").grid); }) -
            check);
    Scene scene;
    add("choose a view and coefficients", time([&] {
            scene = asset::frame_grids(grid, nullptr, 'z', {480, 270}).scene;
        }));
    const Settings settings;
    const double lay_out =
        time([&] { medium::make_layout(*grid, settings.layout, settings.storage, {}); });
    add("lay out for the GPU", lay_out);

    SceneRenderer renderer(get_proc);
    Settings no_light = settings;
    no_light.shadow_volume_size = no_light.ambient_volume_size = 0;
    StillReport report;
    renderer.render(scene, no_light, {.picture = false, .progress = {}}, &report);
    add("upload", report.setup_ms - lay_out);
    FrameClock frames;
    renderer.render(
        scene, settings,
        {.timed_frames = 2, .picture = false, .progress = [&](int, int) { frames.tick(); }},
        &report);
    add("volumes of light", report.setup_ms);
    add("shaders of the first frame", frames.ms(0) - frames.ms(1));
    add("a frame", frames.ms(1));
    return stages;
}

}  // namespace

std::vector<BenchFigure> load_figures(const std::filesystem::path& vdb, gl::GetProc get_proc,
                                      int rounds)
{
    std::vector<Stages> all;
    all.reserve(static_cast<std::size_t>(rounds));
    for (int round = 0; round < rounds; ++round)
        all.push_back(load_once(vdb, get_proc));
    std::vector<BenchFigure> figures;
    const std::string file = vdb.filename().string();
    const auto add = [&](const char* stage, const std::vector<double>& ms) {
        figures.push_back({"load", file, stage, "", 0, "time", "ms", spread_of(ms), {}});
    };
    std::vector<double> sums(all.size());
    for (std::size_t stage = 0; stage < all.front().size(); ++stage) {
        std::vector<double> ms;
        for (std::size_t round = 0; round < all.size(); ++round) {
            ms.push_back(all[round][stage].second);
            sums[round] += ms.back();
        }
        add(all.front()[stage].first, ms);
    }
    add("all", sums);
    return figures;
}

}  // namespace fumarole::study
