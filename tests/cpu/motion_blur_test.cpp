// Media that move while the shutter is open: what a uniform velocity does in closed form, and what
// stays whatever the velocity.

#include "asset/motion_blur.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <numeric>

#include "support/make_vdb.h"
#include "support/temp_folder.h"
#include <fumarole/asset/scene_file.h>
#include <fumarole/asset/vdb_file.h>
#include <fumarole/errors.h>

namespace fumarole::asset {
namespace {

using test::TempFolder;
using test::VdbGrid;
using testing::HasSubstr;

VdbGrid box_of(const char* name, VdbGrid::Type type, glm::ivec3 min, glm::ivec3 max,
               glm::dvec3 value)
{
    VdbGrid grid;
    grid.name = name;
    grid.type = type;
    grid.grid_class = "unknown";
    grid.world_from_index = glm::dmat4(glm::dmat3(0.5));  // voxels of half a metre
    grid.world_from_index[3] = {3, -2, 1, 1};
    grid.boxes = {{min, max, value}};
    return grid;
}

/// Smoke of ten voxels along x, which goes four voxels in negative x while the shutter is open.
std::filesystem::path moving_box(const TempFolder& folder)
{
    const auto file = folder.path() / "moving.vdb";
    const glm::ivec3 lo(0), hi(9, 3, 3), all(40);
    test::write_vdb(file, {box_of("density", VdbGrid::Type::float32, lo, hi, glm::dvec3(2)),
                           box_of("color", VdbGrid::Type::vec3s, lo, hi, {0.5, 0.25, 1}),
                           box_of("temperature", VdbGrid::Type::float32, lo, hi, glm::dvec3(1500)),
                           box_of("v", VdbGrid::Type::vec3s, -all, all, {-96, 0, 0})});
    return file;
}

Scene read(const TempFolder& folder, const std::filesystem::path& file, const std::string& keys)
{
    return load_scene(folder.write("scene.json", fmt::format(R"({{"resolution": [8, 8],
        "camera": {{"position": [0, -9, 0], "look_at": [0, 0, 0], "vfov_deg": 30}}, "world_radiance": [0, 0, 0],
        "lights": [], "surfaces": [], "media": [{{"type": "vdb", "file": "{}", "grid": "density",
        "sigma_s_per_density": [1, 1, 1], "color_grid": "color", "temperature_grid": "temperature",
        "temperature_scale": 1{}}}]}})",
                                                             file.string(), keys)))
        .scene;
}

double sum_of(const VoxelGrid& grid)
{
    return std::accumulate(grid.values.begin(), grid.values.end(), 0.0);
}

// -96 m/s of half-metre voxels at 24 frames per second are eight voxels a frame, of which half are
// gone while a shutter of half a frame is open. Spread over two voxels to either side, a voxel is
// 1/8, 1/4, 1/4, 1/4, 1/8.
TEST(MotionBlur, AUniformVelocityIsABoxFilterInEitherUnit)
{
    const TempFolder folder;
    const auto file = moving_box(folder);
    const Scene by_metres = read(folder, file, R"(, "velocity_grid": "v", "shutter": 0.5)");
    const Scene by_voxels = read(folder, file,
                                 R"(, "velocity_grid": "v", "velocity_unit": "voxels/frame",
                                    "shutter": 0.0416666666666666666)");
    for (const Scene& scene : {by_metres, by_voxels}) {
        const auto& medium = std::get<GridMedium>(scene.media[0]);
        const VoxelLookup density(*medium.density), color(*medium.color),
            temperature(*medium.temperature);
        const double share[] = {0, 0.125, 0.375, 0.625, 0.875, 1, 1};
        for (int x = -3; x <= 3; ++x) {
            const double expected = share[x + 3];
            for (const int at : {x, 9 - x}) {
                EXPECT_NEAR(density.value({at, 1, 2}).x, 2 * expected, 0.03) << at;
                EXPECT_NEAR(std::pow(temperature.value({at, 1, 2}).x / 1500, 4), expected, 0.015)
                    << at;
                if (expected > 0) {
                    EXPECT_NEAR(glm::length(color.value({at, 1, 2}) - glm::vec3(0.5, 0.25, 1)), 0,
                                1e-5)
                        << at;
                }
            }
            EXPECT_EQ(density.value({x, 4, 2}).x, 0);
        }
        EXPECT_NEAR(sum_of(*medium.density), 2 * 10 * 4 * 4, 1e-3);
        EXPECT_NEAR(medium.density->max_value, 2, 1e-5);
    }
}

TEST(MotionBlur, OffByDefaultTheGridsAreThoseOfTheFile)
{
    const TempFolder folder;
    const auto file = moving_box(folder);
    const Scene plain = read(folder, file, "");
    const Scene closed = read(folder, file, R"(, "velocity_grid": "v")");
    const auto& a = std::get<GridMedium>(plain.media[0]);
    const auto& b = std::get<GridMedium>(closed.media[0]);
    EXPECT_EQ(a.density->values, b.density->values);
    EXPECT_EQ(a.density->tiles.size(), b.density->tiles.size());
    EXPECT_EQ(a.motion.shutter, 0);
}

// A whirl that shears and stretches, of a grid that is turned and mirrored.
TEST(MotionBlur, NothingIsLostOnTheWayAndThreadsDontMatter)
{
    VoxelGrid grid, velocity;
    std::vector<float> values;
    for (int i = 0; i < 20 * 20 * 20; ++i)
        values.push_back(static_cast<float>((i * 7919) % 101) / 100.0f);
    glm::dmat4 turned(1);
    turned[0] = {0, 0.1, 0.02, 0};
    turned[1] = {0.1, 0, 0, 0};
    turned[2] = {0, 0.03, 0.1, 0};
    grid = make_voxel_grid(values, glm::ivec3(20), turned);
    velocity = grid;
    velocity.channels = 3;
    velocity.values.clear();
    for (const glm::ivec3& brick : velocity.bricks)
        for (int i = 0; i < VoxelGrid::kBrickVoxels; ++i) {
            const glm::vec3 at(brick * 8 + glm::ivec3(i % 8, i / 8 % 8, i / 64));
            velocity.values.insert(velocity.values.end(),
                                   {0.08f * (at.y - 10), -0.05f * at.x, 0.04f * (at.z - 4)});
        }
    const Displacement by{&velocity, glm::dmat3(1)};
    const VoxelGrid moved = moved_grid(grid, by, Kept::sum, "test");
    EXPECT_NEAR(sum_of(moved) / sum_of(grid), 1, 1e-6);
    EXPECT_GT(moved.bricks.size(), grid.bricks.size());
    EXPECT_LT(moved.max_value, grid.max_value);
    EXPECT_EQ(moved.values, moved_grid(grid, by, Kept::sum, "test").values);
}

TEST(MotionBlur, SaysWhatIsWrong)
{
    const TempFolder folder;
    const auto file = moving_box(folder);
    const auto said = [&](const std::string& keys) -> std::string {
        try {
            read(folder, file, keys);
        } catch (const Error& error) {
            return error.what();
        }
        return "";
    };
    EXPECT_THAT(said(R"(, "velocity_grid": "v", "velocity_unit": "voxels/frame", "shutter": 3)"),
                HasSubstr("moves by 288 voxels while the shutter is open"));
    EXPECT_THAT(said(R"(, "velocity_grid": "density", "shutter": 1)"),
                HasSubstr("one number a voxel, and a velocity needs three"));
    EXPECT_THAT(said(R"(, "velocity_grid": "w", "shutter": 1)"), HasSubstr("no grid 'w'"));
    EXPECT_THAT(said(R"(, "shutter": 1)"), HasSubstr("'shutter' needs 'velocity_grid'"));
    EXPECT_THAT(said(R"(, "velocity_grid": "v", "velocity_unit": "km/h")"),
                HasSubstr("velocity_unit"));
}

TEST(MotionBlur, IsKeptByASavedScene)
{
    const TempFolder folder;
    const Scene scene = read(folder, moving_box(folder), R"(, "velocity_grid": "v",
        "velocity_unit": "voxels/frame", "shutter": 0.01)");
    save_scene(scene, folder.path() / "saved.json");
    const Scene again = parse_scene(folder.path() / "saved.json");
    EXPECT_EQ(std::get<GridMedium>(again.media[0]).motion,
              std::get<GridMedium>(scene.media[0]).motion);
}

}  // namespace
}  // namespace fumarole::asset
