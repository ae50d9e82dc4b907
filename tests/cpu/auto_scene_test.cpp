// auto_scene: a bare grid becomes a picture in which something is seen, whatever its units,
// transform and range. Held against closed forms and by projecting the content into the picture.

#include <fumarole/asset/auto_scene.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>
#include <string>

#include "blackbody.h"
#include "support/make_vdb.h"
#include "support/temp_folder.h"
#include <fumarole/asset/scene_file.h>
#include <fumarole/errors.h>

namespace fumarole::asset {

namespace {

namespace fs = std::filesystem;

const fs::path kSamples = FUM_TEST_DATA;

/// Bricks `count` along each axis from `first`, with `value(voxel)`.
template <class Value>
VoxelGrid grid_of(const glm::ivec3& first, const glm::ivec3& count, Value value)
{
    VoxelGrid grid;
    grid.name = "density";
    bool any = false;
    for (int bz = 0; bz < count.z; ++bz)
        for (int by = 0; by < count.y; ++by)
            for (int bx = 0; bx < count.x; ++bx) {
                const glm::ivec3 brick = first + glm::ivec3{bx, by, bz};
                grid.bricks.push_back(brick);
                for (int v = 0; v < VoxelGrid::kBrickVoxels; ++v) {
                    const glm::ivec3 at = brick * 8 + glm::ivec3{v % 8, v / 8 % 8, v / 64};
                    const float x = value(at);
                    grid.values.push_back(x);
                    grid.max_value = std::max(grid.max_value, x);
                    if (x > 0) {
                        grid.index_min = any ? glm::min(grid.index_min, at) : at;
                        grid.index_max = any ? glm::max(grid.index_max, at) : at;
                        any = true;
                    }
                }
            }
    return grid;
}

/// An ellipsoid with a soft edge, off the origin, about 20 x 26 x 34 voxels.
VoxelGrid ball(float scale = 1)
{
    return grid_of({-2, 1, 0}, {3, 4, 5}, [=](const glm::ivec3& at) {
        const double r =
            glm::length((glm::dvec3(at) - glm::dvec3{-4, 24, 20}) / glm::dvec3{9, 13, 17});
        return scale * static_cast<float>(std::clamp(4 * (1 - r), 0.0, 1.0));
    });
}

double mean_opacity_of_box(const VoxelGrid& grid, double value, double sigma_t)
{
    const glm::dvec3 voxels = glm::dvec3(grid.index_max - grid.index_min) + 1.0;
    double opaque = 0, count = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double spacing = glm::length(glm::dvec3(grid.world_from_index[axis]));
        const double columns = voxels[(axis + 1) % 3] * voxels[(axis + 2) % 3];
        opaque += columns * -std::expm1(-sigma_t * value * voxels[axis] * spacing);
        count += columns;
    }
    return opaque / count;
}

TEST(SigmaTForOpacity, SolvesTheClosedFormOfABox)
{
    VoxelGrid grid = grid_of({-1, 0, 2}, {3, 2, 1}, [](const glm::ivec3&) { return 0.7f; });
    grid.world_from_index = glm::scale(glm::dmat4(1), glm::dvec3{0.1, 0.25, 3});
    for (const double opacity : {0.01, 0.5, 0.75, 0.99}) {
        const double sigma_t = sigma_t_for_opacity(grid, opacity);
        EXPECT_NEAR(mean_opacity_of_box(grid, double{0.7f}, sigma_t), opacity, 1e-9);
    }
}

TEST(SigmaTForOpacity, SumsTheColumnsOfTheVoxels)
{
    // No two columns alike, none faint; summed voxel by voxel here.
    VoxelGrid grid = grid_of({-1, 0, 1}, {2, 1, 2}, [](const glm::ivec3& at) {
        return 0.2f +
               0.01f * static_cast<float>((at.x * 31 + at.y * at.y * 17 + at.z * 7 + 999) % 101);
    });
    grid.world_from_index = glm::scale(glm::dmat4(1), glm::dvec3{0.2, 0.1, 0.05});
    const double sigma_t = sigma_t_for_opacity(grid, 0.75);
    const VoxelLookup lookup(grid);
    double opaque = 0, count = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        glm::ivec3 at;
        for (at[u] = grid.index_min[u]; at[u] <= grid.index_max[u]; ++at[u]) {
            for (at[v] = grid.index_min[v]; at[v] <= grid.index_max[v]; ++at[v]) {
                double column = 0;
                for (at[axis] = grid.index_min[axis]; at[axis] <= grid.index_max[axis]; ++at[axis])
                    column += double{lookup.value(at).x} * grid.world_from_index[axis][axis];
                opaque -= std::expm1(-sigma_t * column);
                count += 1;
            }
        }
    }
    EXPECT_NEAR(opaque / count, 0.75, 1e-9);
}

TEST(SigmaTForOpacity, TilesCountAsTheBricksTheyStandFor)
{
    const VoxelGrid bricks = grid_of({-3, 0, 1}, {2, 3, 4}, [](const glm::ivec3&) { return 2.0f; });
    VoxelGrid tiles = bricks;
    tiles.bricks.clear();
    tiles.values.clear();
    tiles.tiles = {{{-3, 0, 1}, {-2, 2, 4}, glm::vec3{2}}};
    EXPECT_NEAR(sigma_t_for_opacity(tiles, 0.75) / sigma_t_for_opacity(bricks, 0.75), 1, 1e-9);

    // A tile over bricks, in the same columns along z.
    VoxelGrid mixed = bricks;
    mixed.tiles = {{{-3, 0, 5}, {-2, 2, 6}, glm::vec3{2}}};
    mixed.index_max.z += 16;
    const VoxelGrid all = grid_of({-3, 0, 1}, {2, 3, 6}, [](const glm::ivec3&) { return 2.0f; });
    EXPECT_NEAR(sigma_t_for_opacity(mixed, 0.75) / sigma_t_for_opacity(all, 0.75), 1, 1e-9);
}

TEST(SigmaTForOpacity, GoesWithUnitsAndNotWithThePose)
{
    VoxelGrid grid = ball();
    const double sigma_t = sigma_t_for_opacity(grid, 0.75);
    for (const double scale : {1e-3, 100.0}) {
        for (const float value : {1e-30f, 1.0f, 1e30f}) {
            VoxelGrid other = ball(value);
            other.world_from_index =
                glm::scale(glm::rotate(glm::translate(glm::dmat4(1), {1e6, -5, 3}), 0.7,
                                       glm::normalize(glm::dvec3{1, 2, -1})),
                           glm::dvec3{scale, -scale, scale});  // mirrored too
            // Values are floats: 1e-7.
            EXPECT_NEAR(sigma_t_for_opacity(other, 0.75) * scale * double{value} / sigma_t, 1,
                        1e-6);
        }
    }
}

TEST(SigmaTForOpacity, HazeDoesNotDecide)
{
    // Nine columns in ten are haze: were they to be 75 % opaque, the ball would be a solid.
    const VoxelGrid clean = ball();
    VoxelGrid hazy = grid_of({-10, -7, -8}, {20, 20, 20}, [](const glm::ivec3&) { return 1e-5f; });
    const VoxelLookup lookup(clean);
    for (std::size_t b = 0; b < hazy.bricks.size(); ++b)
        for (int v = 0; v < VoxelGrid::kBrickVoxels; ++v)
            hazy.values[b * VoxelGrid::kBrickVoxels + static_cast<std::size_t>(v)] +=
                lookup.value(hazy.bricks[b] * 8 + glm::ivec3{v % 8, v / 8 % 8, v / 64}).x;
    hazy.max_value = 1 + 1e-5f;
    const double ratio = sigma_t_for_opacity(hazy, 0.75) / sigma_t_for_opacity(clean, 0.75);
    EXPECT_NEAR(ratio, 1, 0.15);  // the rim of the ball itself falls under the bar a little sooner

    // Nor does it frame: the camera keeps its distance.
    const auto shared = [](const VoxelGrid& g) { return std::make_shared<const VoxelGrid>(g); };
    const Camera with = frame_grids(shared(hazy), nullptr, 'z', {480, 270}).scene.camera;
    const Camera without = frame_grids(shared(clean), nullptr, 'z', {480, 270}).scene.camera;
    EXPECT_NEAR(glm::distance(with.position, with.look_at) /
                    glm::distance(without.position, without.look_at),
                1, 0.02);
}

/// The part of the picture from -1 to 1 that a grid's voxels of at least 0.02 of its maximum take,
/// by projecting each; x and y apart.
struct Seen {
    glm::dvec2 min{1e9}, max{-1e9};
    double nearest = 1e300;
    double lowest = 1e300;  ///< half a voxel below the lowest centre
};

Seen project(const VoxelGrid& grid, const Camera& camera, double aspect)
{
    const glm::dvec3 forward = glm::normalize(camera.look_at - camera.position);
    const glm::dvec3 right = glm::normalize(glm::cross(forward, camera.up));
    const glm::dvec3 up = glm::cross(right, forward);
    const double slope = std::tan(glm::radians(camera.vfov_deg / 2));
    double half_voxel = 0;
    for (int axis = 0; axis < 3; ++axis)
        half_voxel += 0.5 * std::abs(glm::dot(glm::dvec3(grid.world_from_index[axis]), camera.up));
    Seen seen;
    for (std::size_t b = 0; b < grid.bricks.size(); ++b) {
        for (int v = 0; v < VoxelGrid::kBrickVoxels; ++v) {
            if (grid.values[b * VoxelGrid::kBrickVoxels + static_cast<std::size_t>(v)] <
                0.02f * grid.max_value)
                continue;
            const glm::dvec3 p =
                grid.world_from_index *
                glm::dvec4(grid.bricks[b] * 8 + glm::ivec3{v % 8, v / 8 % 8, v / 64}, 1);
            const glm::dvec3 q = p - camera.position;
            const double z = glm::dot(q, forward);
            const glm::dvec2 ndc =
                glm::dvec2(glm::dot(q, right) / aspect, glm::dot(q, up)) / (z * slope);
            seen.min = glm::min(seen.min, ndc);
            seen.max = glm::max(seen.max, ndc);
            seen.nearest = std::min(seen.nearest, z);
            seen.lowest = std::min(seen.lowest, glm::dot(p, camera.up) - half_voxel);
        }
    }
    return seen;
}

struct Pose {
    const char* name;
    glm::dmat4 world_from_index;
};

std::vector<Pose> poses()
{
    const glm::dmat4 one(1);
    const glm::dmat4 turned = glm::rotate(one, 1.1, glm::normalize(glm::dvec3{1, 0.4, -0.2}));
    glm::dmat4 sheared = one;
    sheared[1][0] = 0.6;
    return {
        {"as_is", one},
        {"millimetres", glm::scale(one, glm::dvec3{1e-3})},
        {"hundred_metres", glm::scale(one, glm::dvec3{100})},
        {"turned", turned},
        {"mirrored_and_flat", glm::scale(one, glm::dvec3{-0.5, 0.5, 0.05})},
        {"sheared", turned * sheared},
        {"far_away", glm::translate(one, {1e6, -2e6, 3e5}) * glm::scale(turned, glm::dvec3{0.02})}};
}

TEST(FrameGrids, ContentFillsThePictureWhateverThePose)
{
    for (const Pose& pose : poses()) {
        for (const char up : {'y', 'z'}) {
            for (const glm::uvec2 resolution : {glm::uvec2{480, 270}, glm::uvec2{200, 900}}) {
                const std::string where = fmt::format("{} {} {}", pose.name, up, resolution.x);
                VoxelGrid grid = ball();
                grid.world_from_index = pose.world_from_index;
                const auto shared = std::make_shared<const VoxelGrid>(grid);
                const Scene scene = frame_grids(shared, nullptr, up, resolution).scene;
                EXPECT_EQ(scene.resolution, resolution);
                const Camera& camera = scene.camera;
                const Seen seen = project(grid, camera, double(resolution.x) / resolution.y);

                const glm::dvec2 span = (seen.max - seen.min) / 2.0;
                // 0.8, less half a voxel in 20 and the soft edge, which project() leaves out, and 1
                // % by rounding to three digits.
                EXPECT_LT(std::max(span.x, span.y), 0.81) << where;
                EXPECT_GT(std::max(span.x, span.y), 0.72) << where;
                EXPECT_LT(std::max(seen.max.x, seen.max.y), 0.85) << where;
                EXPECT_GT(std::min(seen.min.x, seen.min.y), -0.85) << where;

                const glm::dvec3 axis = up == 'y' ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1);
                EXPECT_EQ(camera.up, axis) << where;
                EXPECT_LT(camera.look_at[up - 'x'], camera.position[up - 'x']) << where;
                EXPECT_LT(camera.near, 0.5 * seen.nearest) << where;
                EXPECT_GT(camera.far, 100 * seen.nearest) << where;

                // The ground is under all of the content, close, wide, and under the camera.
                const auto& ground = std::get<BoxSurface>(scene.surfaces.at(0));
                const int u = up - 'x';
                const double distance = glm::distance(camera.position, camera.look_at);
                EXPECT_LE(ground.max[u], seen.lowest) << where;
                EXPECT_GT(ground.max[u], seen.lowest - 0.1 * distance) << where;
                EXPECT_GT(camera.position[u], ground.max[u]) << where;
                EXPECT_LT(ground.min[u], ground.max[u]) << where;
                for (int a = 0; a < 3; ++a) {
                    if (a != u) {
                        EXPECT_LT(ground.min[a], camera.look_at[a] - 20 * distance) << where;
                        EXPECT_GT(ground.max[a], camera.look_at[a] + 20 * distance) << where;
                        // Its end is out of sight: farther than the far plane's own corners.
                        const double slope = std::tan(glm::radians(camera.vfov_deg / 2));
                        const double corner =
                            camera.far *
                            std::hypot(1.0, slope, slope * resolution.x / resolution.y);
                        EXPECT_GT(ground.max[a] - camera.position[a], corner) << where;
                        EXPECT_GT(camera.position[a] - ground.min[a], corner) << where;
                    }
                }

                const auto& sun = std::get<SunLight>(scene.lights.at(0));
                EXPECT_NEAR(glm::length(sun.direction_to_light), 1, 1e-12) << where;
                EXPECT_NEAR(glm::degrees(std::asin(sun.direction_to_light[u])), 45, 10) << where;
                const glm::dvec3 view = glm::normalize(camera.look_at - camera.position);
                EXPECT_LT(glm::dot(sun.direction_to_light, glm::cross(view, axis)), -0.3)
                    << where;  // from the left
            }
        }
    }
}

TEST(FrameGrids, SameGridUpInYIsTheSamePicture)
{
    // z-up (x, y, z) is y-up (x, z, -y).
    VoxelGrid z_up = ball();
    VoxelGrid y_up = z_up;
    y_up.world_from_index = glm::dmat4({1, 0, 0, 0}, {0, 0, -1, 0}, {0, 1, 0, 0}, {0, 0, 0, 1});
    const Scene a =
        frame_grids(std::make_shared<const VoxelGrid>(z_up), nullptr, 'z', {480, 270}).scene;
    const Scene b =
        frame_grids(std::make_shared<const VoxelGrid>(y_up), nullptr, 'y', {480, 270}).scene;
    const auto turned = [](const glm::dvec3& v) { return glm::dvec3{v.x, v.z, -v.y}; };
    EXPECT_LT(glm::distance(turned(a.camera.position), b.camera.position), 1e-9);
    EXPECT_LT(glm::distance(turned(a.camera.look_at), b.camera.look_at), 1e-9);
    EXPECT_LT(glm::distance(turned(std::get<SunLight>(a.lights[0]).direction_to_light),
                            std::get<SunLight>(b.lights[0]).direction_to_light),
              1e-12);
}

TEST(FrameGrids, OneVoxelIsAScene)
{
    const auto grid =
        std::make_shared<const VoxelGrid>(grid_of({5, 5, 5}, {1, 1, 1}, [](const glm::ivec3& at) {
            return at == glm::ivec3{43} ? 1e-4f : 0;
        }));
    const LoadedScene loaded = frame_grids(grid, nullptr, 'z', {64, 64});
    const auto& medium = std::get<GridMedium>(loaded.scene.media.at(0));
    // Its columns are one voxel, 1 m, of 1e-4.
    const double sigma_t =
        double{medium.sigma_s_per_density.x} + double{medium.sigma_a_per_density.x};
    EXPECT_NEAR(-std::expm1(-sigma_t * 1e-4), 0.75, 0.01);
    EXPECT_TRUE(std::isfinite(loaded.scene.camera.position.x));
    EXPECT_NEAR(loaded.scene.camera.look_at.x, 43, 0.05);
}

TEST(FrameGrids, EmissionShinesByItsBrightColumns)
{
    // A box of flame: every line of sight along x is as bright as the others.
    VoxelGrid flame = grid_of({-1, 2, 1}, {1, 1, 1}, [](const glm::ivec3&) { return 40.0f; });
    flame.name = "flame";
    for (const double spacing : {0.001, 1.0, 50.0}) {
        VoxelGrid density = ball();
        density.world_from_index = flame.world_from_index =
            glm::scale(glm::dmat4(1), glm::dvec3{spacing});
        const LoadedScene loaded =
            frame_grids(std::make_shared<const VoxelGrid>(density),
                        std::make_shared<const VoxelGrid>(flame), 'z', {480, 270});
        const auto& medium = std::get<GridMedium>(loaded.scene.media.at(0));
        ASSERT_TRUE(medium.emission);
        EXPECT_EQ(medium.emission_grid, "flame");
        const glm::dvec3 radiance = glm::dvec3(medium.emission_per_unit) * 8.0 * spacing * 40.0;
        const double luminance = glm::dot(radiance, glm::dvec3{0.2126, 0.7152, 0.0722});
        const glm::vec3 sun = std::get<SunLight>(loaded.scene.lights.at(0)).irradiance;
        const double sunlit = glm::dot(glm::dvec3(sun), glm::dvec3{0.2126, 0.7152, 0.0722}) / 12.57;
        EXPECT_NEAR(luminance / sunlit, 3, 0.05);  // three digits
        EXPECT_GT(radiance.r, radiance.g);
        EXPECT_GT(radiance.g, radiance.b);
        EXPECT_NE(loaded.notes.at(1).find("'flame' glows"), std::string::npos);
    }
}

TEST(FrameGrids, FlamesOutsideTheSmokeAreFramedToo)
{
    const auto density = std::make_shared<const VoxelGrid>(ball());
    VoxelGrid flame = grid_of({-1, 3, -6}, {1, 1, 2}, [](const glm::ivec3&) { return 1.0f; });
    const Scene scene =
        frame_grids(density, std::make_shared<const VoxelGrid>(flame), 'z', {480, 270}).scene;
    const Seen seen = project(flame, scene.camera, 480.0 / 270);
    EXPECT_GT(seen.min.y, -0.82);
    EXPECT_LE(std::get<BoxSurface>(scene.surfaces.at(0)).max.z, seen.lowest);
}

TEST(FrameGrids, NumbersAreRoundSoThatTheSceneReadsWell)
{
    VoxelGrid grid = ball(0.123f);
    grid.world_from_index = glm::scale(glm::dmat4(1), glm::dvec3{0.0371});
    const Scene scene =
        frame_grids(std::make_shared<const VoxelGrid>(grid), nullptr, 'z', {480, 270}).scene;
    const auto short_text = [](double v) { return fmt::format("{}", v).size() <= 6; };
    const auto& medium = std::get<GridMedium>(scene.media.at(0));
    EXPECT_EQ(fmt::format("{:.3g}", medium.sigma_s_per_density.x),
              fmt::format("{}", medium.sigma_s_per_density.x));
    for (int axis = 0; axis < 3; ++axis) {
        EXPECT_TRUE(short_text(scene.camera.position[axis])) << scene.camera.position[axis];
        EXPECT_TRUE(short_text(scene.camera.look_at[axis])) << scene.camera.look_at[axis];
    }
    EXPECT_TRUE(short_text(scene.camera.near)) << scene.camera.near;
}

GridInfo grid_info(const std::string& name, std::uint64_t active, double max = 1)
{
    GridInfo info;
    info.name = name;
    info.active_voxels = active;
    info.max = max;
    return info;
}

TEST(GuessUp, AsksTheWriterAndThenTheShape)
{
    const auto guess = [](const char* creator, const glm::dvec3& size) {
        VdbInfo file;
        file.creator = creator;
        return guess_up(file, size);
    };
    const glm::dvec3 cube{1, 1, 1};
    EXPECT_EQ(guess("Blender/OpenVDBWriter", {1, 3, 1}).axis, 'z');
    EXPECT_EQ(guess("mantaflow", cube).axis, 'z');
    EXPECT_EQ(guess("Houdini 17.5.173/GEO_VDBTranslator", {1, 1, 3}).axis, 'y');
    EXPECT_NE(guess("Houdini 17.5.173", cube).why.find("Houdini 17.5.173"), std::string::npos);
    EXPECT_EQ(guess("", cube).axis, 'y');
    EXPECT_EQ(guess("", {3.7, 3.8, 5.1}).axis, 'z');  // a plume
    EXPECT_EQ(guess("", {198, 206, 156}).axis, 'z');  // a cloud, flat
    EXPECT_EQ(guess("", {52, 105, 53}).axis, 'y');    // a plume
    EXPECT_EQ(guess("", {8.9, 3.6, 8.9}).axis, 'y');  // a ring, flat
    EXPECT_EQ(guess("", {2, 1.5, 4}).axis, 'z');      // tall
    EXPECT_EQ(guess("", {410, 277, 507}).axis, 'y');  // a wide cloud does not tell
}

TEST(GuessUp, AsksTheGridsBeforeTheShape)
{
    const glm::dvec3 lying{10, 7, 5}, tall_in_y{1, 3, 1};
    VdbInfo blender;  // Mantaflow's own files name no writer
    for (const char* name : {"velocity", "density", "shadow", "temperature", "flame"})
        blender.grids.push_back(grid_info(name, 100));
    EXPECT_EQ(guess_up(blender, lying).axis, 'z');
    EXPECT_EQ(guess_up(blender, tall_in_y).axis, 'z');
    EXPECT_NE(guess_up(blender, lying).why.find("Blender"), std::string::npos);

    VdbInfo other;
    other.grids = {grid_info("density", 100), grid_info("Vel", 100)};
    other.grids[1].value_type = "vec3s";
    other.grids[1].mean_vector = {0.1, -0.2, 1};
    EXPECT_EQ(guess_up(other, tall_in_y).axis, 'z');
    EXPECT_NE(guess_up(other, lying).why.find("'Vel' rises in z"), std::string::npos);
    other.grids[1].mean_vector = {0.1, 1, -0.2};
    EXPECT_EQ(guess_up(other, lying).axis, 'y');
    other.grids[1].mean_vector = {0, 0, -1};  // what falls does not tell: rain, or a fountain
    EXPECT_EQ(guess_up(other, tall_in_y).axis, 'y');
    other.creator = "Houdini 20";
    other.grids[1].mean_vector = {0, 0, 1};  // wind
    EXPECT_EQ(guess_up(other, lying).axis, 'y');
}

TEST(GuessEmissionGrid, TakesFlamesAndLocalHeat)
{
    const auto guess = [](std::vector<GridInfo> grids) {
        VdbInfo file;
        file.grids = std::move(grids);
        file.grids.push_back(grid_info("density", 1000));
        return guess_emission_grid(file, "density");
    };
    EXPECT_EQ(guess({}), "");
    EXPECT_EQ(guess({grid_info("velocity", 900)}), "");
    EXPECT_EQ(guess({grid_info("temperature", 100), grid_info("flame", 900)}), "flame");
    EXPECT_EQ(guess({grid_info("Fire[1]", 900)}), "Fire[1]");
    EXPECT_EQ(guess({grid_info("flame", 0), grid_info("burn", 9)}), "burn");
    EXPECT_EQ(guess({grid_info("flame", 10, 0)}), "");      // nothing but zeros
    EXPECT_EQ(guess({grid_info("temperature", 900)}), "");  // all of the smoke is warm
    EXPECT_EQ(guess({grid_info("Temperature", 500)}), "Temperature");
    EXPECT_EQ(guess({grid_info("heat", 990), grid_info("temp", 50)}), "temp");
    GridInfo refused = grid_info("flame", 10);
    refused.refusal = "a point grid";
    EXPECT_EQ(guess({refused}), "");

    VdbInfo fire;
    fire.grids = {grid_info("flame", 10)};
    EXPECT_EQ(guess_emission_grid(fire, "flame"), "flame");  // fire without smoke burns
    fire.grids.push_back(grid_info("soot", 10));
    EXPECT_EQ(guess_emission_grid(fire, "flame"), "");  // it was asked for as the smoke
}

TEST(AutoScene, MakesASceneOfASmoke)
{
    const fs::path file = kSamples / "smoke_plume.vdb";
    const LoadedScene loaded = make_auto_scene(file, {});
    const Scene& scene = loaded.scene;
    const auto& medium = std::get<GridMedium>(scene.media.at(0));
    EXPECT_EQ(medium.file, file.string());
    EXPECT_EQ(medium.grid, "density");
    ASSERT_TRUE(medium.density);
    EXPECT_FALSE(medium.emission);
    EXPECT_EQ(scene.camera.up, glm::dvec3(0, 0, 1));
    std::string notes;
    for (const std::string& note : loaded.notes)
        notes += note + '\n';
    EXPECT_NE(notes.find("z is up (as deep in y as wide in x)"), std::string::npos) << notes;
    EXPECT_NE(notes.find("/m per density: average line of sight 75 % opaque"), std::string::npos)
        << notes;

    // What is written is read back as the same scene.
    const std::string text = scene_to_json(scene, kSamples);
    EXPECT_NE(text.find("\"file\": \"smoke_plume.vdb\""), std::string::npos);
    EXPECT_NE(text.find("[-0.744, -0.192, 0.64]"), std::string::npos) << text;

    const Scene other = make_auto_scene(file, {.grid = "density", .up = 'y'}).scene;
    EXPECT_EQ(other.camera.up, glm::dvec3(0, 1, 0));
}

TEST(AutoScene, FireGlowsByItsFlameAndNotByItsTemperature)
{
    const LoadedScene loaded = make_auto_scene(kSamples / "fire_plume.vdb", {});
    const auto& medium = std::get<GridMedium>(loaded.scene.media.at(0));
    EXPECT_EQ(medium.emission_grid, "flame");
    ASSERT_TRUE(medium.emission);
    EXPECT_GT(medium.emission_per_unit.r, 0);
}

TEST(GuessTemperatureGrid, TakesWhatSimulatorsCallItWhereNoFlameTells)
{
    const auto guess = [](std::vector<GridInfo> grids) {
        VdbInfo file;
        file.grids = std::move(grids);
        file.grids.push_back(grid_info("density", 1000));
        return guess_temperature_grid(file, "density");
    };
    EXPECT_EQ(guess({}), "");
    EXPECT_EQ(guess({grid_info("temperature", 900)}), "temperature");
    EXPECT_EQ(guess({grid_info("Temperature[1]", 9)}), "Temperature[1]");
    EXPECT_EQ(guess({grid_info("heat", 9), grid_info("temp", 9)}), "temp");
    EXPECT_EQ(guess({grid_info("heat", 9), grid_info("temperature", 0)}), "heat");
    EXPECT_EQ(guess({grid_info("heat", 9), grid_info("flame", 9)}), "");
    EXPECT_EQ(guess({grid_info("heat", 9), grid_info("flame", 0)}), "heat");
    VdbInfo hot;
    hot.grids = {grid_info("temperature", 10)};
    EXPECT_EQ(guess_temperature_grid(hot, "temperature"), "temperature") << "it is all there is";
    hot.grids.push_back(grid_info("fog", 10));
    EXPECT_EQ(guess_temperature_grid(hot, "temperature"), "") << "it was asked for as smoke";
}

test::VdbGrid box_grid(const std::string& name, const glm::ivec3& min, const glm::ivec3& max,
                       const glm::dvec3& value, test::VdbGrid::Type type = {})
{
    test::VdbGrid grid;
    grid.name = name;
    grid.type = type;
    for (int z = min.z; z <= max.z; ++z)
        for (int y = min.y; y <= max.y; ++y)
            for (int x = min.x; x <= max.x; ++x)
                grid.voxels.push_back({{x, y, z}, value});
    return grid;
}

std::string text_of(const std::vector<std::string>& notes)
{
    std::string text;
    for (const std::string& note : notes)
        text += note + '\n';
    return text;
}

TEST(AutoScene, SaysWhichGridOfWhichWasTakenAndWhatIsNotShown)
{
    const test::TempFolder folder;
    const fs::path file = folder.path() / "a.vdb";
    const glm::ivec3 from(0), to(3);
    test::write_vdb(file, {box_grid("Heat", from, to, glm::dvec3(2)),
                           box_grid("Soot", from, to, glm::dvec3(1)),
                           box_grid("Cd", from, to, {0.5, 0.2, 1}, test::VdbGrid::Type::vec3s),
                           box_grid("vel", from, to, {0, 1, 0}, test::VdbGrid::Type::vec3s)});
    const LoadedScene loaded = make_auto_scene(file, {});
    const std::string notes = text_of(loaded.notes);
    for (const char* line : {"grid 'Soot' is the smoke, of 'Heat', 'Soot', 'Cd', 'vel'\n",
                             "grid 'Cd' colours it\n", "not shown: 'vel'\n",
                             "grid 'Heat' holds up to 2, taken as thousands of kelvin: 2000 K at "
                             "most, glows as a blackbody\n"})
        EXPECT_NE(notes.find(line), std::string::npos) << line << notes;
    const auto& medium = std::get<GridMedium>(loaded.scene.media.front());
    EXPECT_EQ(medium.grid, "Soot");
    EXPECT_EQ(medium.color_grid, "Cd");
    ASSERT_TRUE(medium.color);
    EXPECT_EQ(VoxelLookup(*medium.color).value({1, 1, 1}), glm::vec3(0.5f, 0.2f, 1));
}

// What a bare file can't use is left out or said: it is no reason to show nothing.
TEST(AutoScene, LeavesOutWhatDoesNotFitAndNamesWhatIsTooThin)
{
    const test::TempFolder folder;
    const fs::path file = folder.path() / "a.vdb";
    const glm::ivec3 from(0), to(3);
    test::VdbGrid blue = box_grid("Cd.z", from, to, glm::dvec3(1));
    blue.world_from_index = glm::dmat4(2);
    blue.world_from_index[3].w = 1;
    test::write_vdb(file, {box_grid("density", from, to, glm::dvec3(1)),
                           box_grid("Cd.x", from, to, glm::dvec3(1)),
                           box_grid("Cd.y", from, to, glm::dvec3(1)), blue});
    const LoadedScene coloured = make_auto_scene(file, {});
    EXPECT_EQ(std::get<GridMedium>(coloured.scene.media.front()).color_grid, "");
    EXPECT_NE(text_of(coloured.notes).find("not shown: 'Cd.x', 'Cd.y', 'Cd.z'"), std::string::npos);

    test::write_vdb(file, {box_grid("temperature", from, to, glm::dvec3(300))});
    EXPECT_NE(text_of(make_auto_scene(file, {}).notes).find("'temperature' is drawn as smoke"),
              std::string::npos);

    // Fire without smoke burns.
    for (const char* name : {"flame", "temperature"}) {
        const bool hot = std::string(name) == "temperature";
        test::write_vdb(file, {box_grid(name, from, to, glm::dvec3(1500))});
        const LoadedScene loaded = make_auto_scene(file, {});
        const auto& medium = std::get<GridMedium>(loaded.scene.media.front());
        EXPECT_EQ(hot ? medium.temperature_grid : medium.emission_grid, name);
        EXPECT_EQ(glows_hot(medium), hot);
        EXPECT_EQ(medium.emission_per_unit != glm::vec3(0), !hot);
        EXPECT_NE(text_of(loaded.notes).find("is drawn as fire alone"), std::string::npos);
    }

    test::write_vdb(file, {box_grid("density", from, to, glm::dvec3(1e-30))});
    try {
        make_auto_scene(file, {});
        FAIL() << "was accepted";
    } catch (const Error& error) {
        const std::string text = error.what();
        EXPECT_EQ(text.find(file.string() + ": grid 'density' is next to nothing"), 0u) << text;
    }
}

TEST(AutoScene, ATemperatureGlowsAsABlackbodyWhereItIsHotEnough)
{
    const test::TempFolder folder;
    const fs::path file = folder.path() / "a.vdb";
    const glm::ivec3 from(0), to(15);
    const auto with = [&](const char* name, double value) {
        test::write_vdb(file, {box_grid("density", from, to, glm::dvec3(1)),
                               box_grid(name, from, to, glm::dvec3(value))});
        return make_auto_scene(file, {});
    };
    struct Case {
        const char* name;
        double value, kelvin;  ///< 0: it does not glow
    };
    for (const Case& c : {Case{"temperature", 1.5, 1000},
                          {"Temperature", 2200, 1},
                          {"temp", 900, 1},
                          {"heat", 3, 1000},
                          {"temperature", 1, 0},
                          {"temperature", 293, 0},
                          {"heat", 0.76, 0}}) {
        const LoadedScene loaded = with(c.name, c.value);
        const auto& medium = std::get<GridMedium>(loaded.scene.media.front());
        SCOPED_TRACE(text_of(loaded.notes));
        EXPECT_EQ(medium.emission_grid, "");
        if (c.kelvin == 0) {
            EXPECT_EQ(medium.temperature_grid, "");
            EXPECT_NE(text_of(loaded.notes).find("too cold to glow"), std::string::npos);
            continue;
        }
        EXPECT_EQ(medium.temperature_grid, c.name);
        ASSERT_TRUE(medium.temperature);
        EXPECT_EQ(medium.temperature_scale, c.kelvin);
        EXPECT_TRUE(glows_hot(medium));
        // Sixteen metres of it are three times as bright as sunlit smoke.
        const double sunlit = (8 * 0.2126 + 7.6 * 0.7152 + 6.8 * 0.0722) / (4 * glm::pi<double>());
        EXPECT_NEAR(16 * double(medium.blackbody_intensity) *
                        blackbody_luminance(c.kelvin * c.value) / (3 * sunlit),
                    1, 0.01);
    }
}

// Where a file's temperature is a plume around a core, what glows of it is framed and counted.
TEST(AutoScene, OnlyTheHotPartOfATemperatureCounts)
{
    const test::TempFolder folder;
    const fs::path file = folder.path() / "a.vdb";
    test::VdbGrid hot = box_grid("temperature", {0, 0, 0}, {15, 40, 15}, glm::dvec3(300));
    for (test::VdbVoxel& voxel : hot.voxels)
        if (voxel.index.y < 8)
            voxel.value = glm::dvec3(2000);
    test::write_vdb(file, {box_grid("density", {0, 0, 0}, {15, 15, 15}, glm::dvec3(1)), hot});
    const Scene scene = make_auto_scene(file, {.grid = "", .up = 'y'}).scene;
    const Scene smoke = [&] {
        test::write_vdb(file, {box_grid("density", {0, 0, 0}, {15, 15, 15}, glm::dvec3(1))});
        return make_auto_scene(file, {.grid = "", .up = 'y'}).scene;
    }();
    EXPECT_EQ(scene.camera.position, smoke.camera.position);
    const auto& medium = std::get<GridMedium>(scene.media.front());
    EXPECT_NEAR(16 * double(medium.blackbody_intensity) * blackbody_luminance(2000) / 1.8, 1, 0.1);
}

TEST(AutoScene, ColoursOfThreeGridsAreTakenAndNoneScattersMoreThanIsLost)
{
    const test::TempFolder folder;
    const fs::path file = folder.path() / "a.vdb";
    const glm::ivec3 from(0), to(3);
    test::write_vdb(file, {box_grid("density", from, to, glm::dvec3(1)),
                           box_grid("color_r", from, to, glm::dvec3(3)),
                           box_grid("color_g", from, to, glm::dvec3(1)),
                           box_grid("color_b", from, to, glm::dvec3(0.5))});
    const LoadedScene loaded = make_auto_scene(file, {});
    const auto& medium = std::get<GridMedium>(loaded.scene.media.front());
    EXPECT_EQ(medium.color_grid, "color");
    ASSERT_TRUE(medium.color);
    EXPECT_EQ(VoxelLookup(*medium.color).value({1, 1, 1}), glm::vec3(3, 1, 0.5f));
    const glm::vec3 sigma_t = medium.sigma_s_per_density + medium.sigma_a_per_density;
    EXPECT_NEAR(3 * medium.sigma_s_per_density.r / sigma_t.r, 0.9, 0.01);
    EXPECT_EQ(text_of(loaded.notes).find("not shown"), std::string::npos) << text_of(loaded.notes);
}

/// A plume that grows: frame 1 is empty, frame n reaches 4 n voxels up and to one side.
class Growing : public testing::Test {
protected:
    static constexpr int kFrames = 7;

    void SetUp() override
    {
        test::write_vdb(file(1), {test::VdbGrid{}});
        for (int frame = 2; frame <= kFrames; ++frame)
            test::write_vdb(file(frame), {box_grid("density", {0, 0, 0}, {3, 4 * frame, 3 * frame},
                                                   glm::dvec3(0.5))});
    }
    [[nodiscard]] fs::path file(int frame) const
    {
        return folder_.path() / fmt::format("p.{}.vdb", frame);
    }
    [[nodiscard]] std::string pattern() const { return (folder_.path() / "p.#.vdb").string(); }
    test::TempFolder folder_;
};

TEST_F(Growing, TheWholeSequenceIsInThePicture)
{
    const LoadedScene loaded = make_auto_scene(pattern(), {.grid = "", .up = 'y'});
    const auto& medium = std::get<GridMedium>(loaded.scene.media.front());
    EXPECT_EQ(medium.file, pattern());
    EXPECT_EQ(medium.grid, "density");
    EXPECT_FALSE(medium.density);
    // All frames lie in the last one, so the view is the view of that.
    const Scene last = make_auto_scene(file(kFrames), {.grid = "", .up = 'y'}).scene;
    EXPECT_EQ(loaded.scene.camera, last.camera);
    EXPECT_EQ(loaded.scene.surfaces, last.surfaces);
    EXPECT_NE(text_of(loaded.notes).find("fitted to 7 frames, 1 to 7"), std::string::npos)
        << text_of(loaded.notes);
}

TEST_F(Growing, FramesThatGoAnotherWayAreFramedToo)
{
    // Of many frames not all are read for their values, but all are for their bounds.
    for (int frame = 8; frame <= 30; ++frame)
        test::write_vdb(file(frame), {box_grid("density", {0, 0, 0}, {3, 3, 3}, glm::dvec3(1))});
    test::write_vdb(file(13), {box_grid("density", {-60, 0, 0}, {-58, 3, 3}, glm::dvec3(1))});
    const Camera camera = make_auto_scene(pattern(), {.grid = "", .up = 'y'}).scene.camera;
    for (const int frame : {kFrames, 13}) {
        const Seen seen = project(load_grid(file(frame), "").grid, camera, 480.0 / 270);
        EXPECT_GT(seen.min.x, -0.82) << frame;
        EXPECT_LT(seen.max.x, 0.82) << frame;
        EXPECT_GT(seen.min.y, -0.82) << frame;
        EXPECT_LT(seen.max.y, 0.82) << frame;
    }
}

TEST_F(Growing, AFireOfLaterFramesGlows)
{
    const auto with_flame = [&](int frame, const glm::dvec3& heat) {
        test::VdbGrid flame;
        flame.name = "flame";
        if (heat.x > 0)
            flame = box_grid("flame", {0, 0, 0}, {3, 3, 3}, heat);
        test::write_vdb(file(frame),
                        {box_grid("density", {0, 0, 0}, {3, 9, 3}, glm::dvec3(1)), flame});
    };
    with_flame(2, glm::dvec3(0));
    with_flame(6, glm::dvec3(2));
    const Scene scene = make_auto_scene(pattern(), {}).scene;
    const auto& medium = std::get<GridMedium>(scene.media.front());
    EXPECT_EQ(medium.emission_grid, "flame");
    EXPECT_GT(medium.emission_per_unit.r, 0);
    // By the flame's own columns: 4 m of 2 are three times as bright as sunlit smoke.
    const Scene lit = make_auto_scene(file(6), {}).scene;
    EXPECT_EQ(medium.emission_per_unit, std::get<GridMedium>(lit.media.front()).emission_per_unit);
}

TEST_F(Growing, ATemperatureOfLaterFramesGlowsInOneUnit)
{
    const auto with_heat = [&](int frame, double heat) {
        test::VdbGrid hot;
        hot.name = "temperature";
        if (heat > 0)
            hot = box_grid("temperature", {0, 0, 0}, {3, 3, 3}, glm::dvec3(heat));
        test::write_vdb(file(frame),
                        {box_grid("density", {0, 0, 0}, {3, 9, 3}, glm::dvec3(1)), hot});
    };
    with_heat(2, 0);
    with_heat(4, 293);
    with_heat(6, 1800);
    const Scene scene = make_auto_scene(pattern(), {}).scene;
    const auto& medium = std::get<GridMedium>(scene.media.front());
    EXPECT_EQ(medium.temperature_grid, "temperature");
    EXPECT_EQ(medium.temperature_scale, 1);
    const Scene lit = make_auto_scene(file(6), {}).scene;
    EXPECT_EQ(medium.blackbody_intensity,
              std::get<GridMedium>(lit.media.front()).blackbody_intensity);
}

TEST_F(Growing, ASequenceOfNothingIsRefused)
{
    for (int frame = 2; frame <= kFrames; ++frame)
        test::write_vdb(file(frame), {test::VdbGrid{}});
    EXPECT_THROW(make_auto_scene(pattern(), {}), Error);
    EXPECT_THROW(make_auto_scene((folder_.path() / "q.#.vdb").string(), {}), Error);
}

TEST(AutoScene, BlendersSimulationsAreZUp)
{
    const fs::path file =
        fs::path(FUM_TEST_SHARED) / "vdb/external/blender_mantaflow_fluid_data_0001.vdb";
    if (!fs::exists(file))
        GTEST_SKIP() << "needs " << file;
    EXPECT_EQ(make_auto_scene(file, {}).scene.camera.up, glm::dvec3(0, 0, 1));
}

TEST(AutoScene, RefusesAnEmptyGridAndAMissingOne)
{
    const fs::path file =
        fs::path(FUM_TEST_SHARED) / "vdb/external/blender_mantaflow_fluid_data_0001.vdb";
    if (!fs::exists(file))
        GTEST_SKIP() << "needs " << file;
    try {
        make_auto_scene(file, {.grid = "flame"});
        FAIL() << "an empty grid was taken";
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("grid 'flame' is 0 everywhere"), std::string::npos)
            << error.what();
    }
    EXPECT_THROW(make_auto_scene(file, {.grid = "nothing"}), Error);
    EXPECT_THROW(make_auto_scene("not_there.vdb", {}), Error);
}

}  // namespace

}  // namespace fumarole::asset
