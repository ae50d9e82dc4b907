// Group 12: what no file should hold, and some do.

#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <limits>
#include <unistd.h>

#include "study/handmade_vdb.h"
#include "study/stability_bench.h"
#include <fumarole/asset/vdb_file.h>
#include <fumarole/errors.h>

namespace fumarole::study {

namespace {

namespace fs = std::filesystem;

/// A file that is there as long as this is.
class HostileFile {
public:
    HostileFile(const StabilityBench& bench, std::string_view bytes)
        : path_{bench.scratch() / fmt::format("hostile-{}.vdb", ::getpid())}
    {
        std::ofstream to(path_, std::ios::binary);
        to << bytes;
        if (!to.flush())
            throw Error(fmt::format("{}: can't be written", path_.string()));
    }
    ~HostileFile()
    {
        std::error_code ignored;
        fs::remove(path_, ignored);
    }
    HostileFile(const HostileFile&) = delete;
    HostileFile& operator=(const HostileFile&) = delete;

    [[nodiscard]] const fs::path& path() const { return path_; }

private:
    fs::path path_;
};

VoxelGrid load(const StabilityBench& bench, const std::string& bytes)
{
    const HostileFile file(bench, bytes);
    return asset::load_grid(file.path(), "density").grid;
}

template <class Value> HandmadeBrick brick_of(glm::ivec3 brick, const Value& value)
{
    HandmadeBrick made{brick, {}};
    for (int i = 0; i < 512; ++i)
        made.values[static_cast<std::size_t>(i)] =
            static_cast<float>(value(brick * 8 + glm::ivec3(i & 7, i >> 3 & 7, i >> 6)));
    return made;
}

/// 16 voxels a side, 3 m wide, 5 m ahead of bare_scene's eye.
template <class Value> HandmadeVdb cube_of(const Value& value)
{
    HandmadeVdb made;
    made.world_from_index = voxels(0.2, {-1.5, -6.5, -1.5});
    for (int b = 0; b < 8; ++b)
        made.bricks.push_back(brick_of({b & 1, b >> 1 & 1, b >> 2}, value));
    return made;
}

Scene scene_of(VoxelGrid grid)
{
    Scene scene = bare_scene(32);
    GridMedium smoke;
    smoke.density = std::make_shared<VoxelGrid>(std::move(grid));
    smoke.sigma_s_per_density = {0.5f, 1.0f, 2.0f};
    scene.media = {smoke};
    scene.lights = {SunLight{{0.7, 0.3, 0.6}, glm::vec3(3)}};
    return scene;
}

double wave(glm::ivec3 v)
{
    return 0.5 + 0.4 * std::sin(1.3 * v.x + 0.7 * v.y) * std::sin(0.9 * v.z);
}

/// The picture of a grid with a few such values, and of the same grid with 0 there.
StabilityFigure bad_values(const StabilityBench& bench)
{
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    StabilityFigure worst;
    for (const float bad : {kNan, kInfinity, -kInfinity, -1.0f, -1e30f}) {
        const auto picture = [&](float value) {
            const HandmadeVdb made = cube_of([&](glm::ivec3 v) {
                return (v.x + 3 * v.y + 5 * v.z) % 7 == 0 ? double(value) : wave(v);
            });
            return layer(bench.render(scene_of(load(bench, handmade_vdb(made)))),
                         &Still::composite);
        };
        worst = worse(worst, worst_difference(picture(bad), picture(0)));
    }
    return worst;
}

/// Values so large that coefficients leave what 32-bit floats hold.
StabilityFigure huge_values(const StabilityBench& bench)
{
    StabilityFigure bad;
    for (const double huge : {1e4, 1e19, 3e38}) {
        const HandmadeVdb made =
            cube_of([&](glm::ivec3 v) { return v == glm::ivec3(7, 8, 7) ? huge : wave(v); });
        bad = worse(bad, count_bad(bench.render(scene_of(load(bench, handmade_vdb(made))))));
    }
    return bad;
}

StabilityFigure nothing(const StabilityBench& bench)
{
    StabilityFigure worst;
    const std::array grids{load(bench, handmade_vdb({})),
                           load(bench, handmade_vdb(cube_of([](glm::ivec3) { return 0; }))),
                           VoxelGrid{}};
    for (const VoxelGrid& grid : grids) {
        Scene scene = scene_of(grid);
        scene.world.radiance = {0.3f, 0.7f, 1.1f};
        const Still still = bench.render(scene);
        worst = worse(worst, worst_difference(layer(still, &Still::composite),
                                              layer(still, &Still::surface)));
    }
    return worst;
}

/// A ball's distances, which become fog that rises from 0 at its skin to 1 within 3 voxels; the
/// truth is a grid that holds that rise at its voxels.
StabilityFigure level_set(const StabilityBench& bench)
{
    constexpr double kVoxel = 0.2, kRadius = 6.5, kBand = 3;  // of metres; of voxels
    const auto distance = [](glm::ivec3 v) { return glm::length(glm::dvec3(v) - 7.5) - kRadius; };
    HandmadeVdb made =
        cube_of([&](glm::ivec3 v) { return kVoxel * glm::clamp(distance(v), -kBand, kBand); });
    made.grid_class = "level set";
    made.background = static_cast<float>(kBand * kVoxel);
    const Scene fog = scene_of(*make_grid({2, 2, 2}, made.world_from_index, [&](glm::ivec3 v) {
        return glm::clamp(-distance(v) / kBand, 0.0, 1.0);
    }));
    const Picture truth = true_transmittance(fog);
    const Still still =
        bench.render(scene_of(load(bench, handmade_vdb(made))), bench.full_size(), 0);
    return rms_over_mean(layer(still, &Still::transmittance), truth);
}

/// A grid alone, or with one more brick 2^30 voxels away.
StabilityFigure far_voxels(const StabilityBench& bench)
{
    HandmadeVdb made = cube_of(wave);
    const Picture alone =
        layer(bench.render(scene_of(load(bench, handmade_vdb(made)))), &Still::transmittance);
    made.bricks.push_back(brick_of(glm::ivec3(0, 0, 1 << 27), wave));
    try {
        const Still both = bench.render(scene_of(load(bench, handmade_vdb(made))));
        return worst_difference(layer(both, &Still::transmittance), alone);
    } catch (const Error&) {
        return {0};  // larger than a grid may be, and said so
    }
}

bool sane(const VoxelGrid& grid)
{
    for (const float v : grid.values)
        if (!(v >= 0 && std::isfinite(v)))
            return false;
    for (const VoxelTile& tile : grid.tiles)
        if (!(tile.value.x >= 0 && std::isfinite(tile.value.x)))
            return false;
    return grid.values.size() ==
           grid.bricks.size() * VoxelGrid::kBrickVoxels * static_cast<std::size_t>(grid.channels);
}

/// How many of these files were neither refused with a word nor read as a grid of sane numbers;
/// `whole`: or were read at all.
template <class Damage>
StabilityFigure damaged_files(const StabilityBench& bench, bool whole, std::size_t tries,
                              const Damage& damage)
{
    const std::string good = handmade_vdb(cube_of(wave));
    double wrong = 0;
    for (std::size_t i = 0; i < tries; ++i)
        try {
            if (!sane(load(bench, damage(good, i))) || whole)
                ++wrong;
        } catch (const Error&) {
        }
    return {wrong};
}

StabilityFigure torn(const StabilityBench& bench)
{
    constexpr std::size_t kTries = 97;
    return damaged_files(bench, true, kTries, [](const std::string& good, std::size_t i) {
        return good.substr(0, good.size() * i / kTries);
    });
}

/// Bytes of the head one after the other, then some of the tree's.
StabilityFigure forged(const StabilityBench& bench)
{
    constexpr std::size_t kHead = 400, kTries = 600;
    return damaged_files(bench, false, kTries, [](std::string bytes, std::size_t i) {
        const std::size_t at =
            i < kHead ? i : kHead + (bytes.size() - kHead) * (i - kHead) / (kTries - kHead);
        bytes[at] = static_cast<char>(bytes[at] ^ (i % 2 == 0 ? 0xff : 1 << (i / 2 % 8)));
        return bytes;
    });
}

}  // namespace

void add_hostile_cases(std::vector<StabilityCase>& table)
{
    const auto add = [&](std::string name, std::string shows, double bound, std::string unit,
                         std::string reason, StabilityFigure (*measure)(const StabilityBench&)) {
        table.push_back({.group = 12,
                         .name = std::move(name),
                         .shows = std::move(shows),
                         .bound = bound,
                         .unit = std::move(unit),
                         .reason = std::move(reason),
                         .measure = measure});
    };
    add("nan-inf-negative", "largest change from a file with 0 in place of NaN, +-inf, negatives",
        0, "of the radiance", "a reader that cleans them leaves the same bits", bad_values);
    add("huge-density", "values that are no colour, a voxel of up to 3e38", 0, "values",
        "one NaN spreads over its neighbours, and an infinity is one soon", huge_values);
    add("empty-grids", "largest change of the picture by grids of nothing", 0, "of the radiance",
        "nothing in the air leaves the picture's bits", nothing);
    add("level-set", "rms error of T of a ball given by its distances, full size", kJustNoticed,
        "of the mean", std::string(kNoticeReason), level_set);
    add("voxels-2^30-apart", "largest change of T by a brick 2^30 voxels away, 0 if it is refused",
        kHalfFloat, "of T", std::string(kHalfReason), far_voxels);
    add("torn-files", "of 97 files cut short, those that are not refused", 0, "files",
        "a file that is not whole is an error, not a picture of half of it", torn);
    add("forged-files",
        "of 600 files with a wrong byte, those neither refused nor read as sane numbers", 0,
        "files", "what a file says is not believed until it is checked", forged);
}

}  // namespace fumarole::study
