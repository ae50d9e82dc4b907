#include <fumarole/asset/animation.h>

#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/make_vdb.h"
#include "support/temp_folder.h"
#include <fumarole/asset/frame_loader.h>
#include <fumarole/asset/sequence.h>
#include <fumarole/errors.h>

namespace fumarole {
namespace {

namespace fs = std::filesystem;

CameraKey key(double time, glm::dvec3 position, double vfov = 30)
{
    CameraKey key;
    key.time = time;
    key.camera.position = position;
    key.camera.look_at = position + glm::dvec3(0, 1, 0);
    key.camera.vfov_deg = vfov;
    return key;
}

void expect_near(glm::dvec3 a, glm::dvec3 b, double within = 1e-12)
{
    EXPECT_NEAR(glm::length(a - b), 0, within) << a.x << ' ' << a.y << ' ' << a.z;
}

TEST(CameraPath, GoesThroughItsKeysAndStandsStillOutside)
{
    const std::vector<CameraKey> path{key(1, {0, 0, 0}), key(2, {3, 1, 0}), key(5, {4, -2, 7})};
    for (const CameraKey& k : path)
        expect_near(camera_at(path, k.time).position, k.camera.position);
    expect_near(camera_at(path, -10).position, {0, 0, 0});
    expect_near(camera_at(path, 99).position, {4, -2, 7});
    expect_near(camera_at({path[1]}, 7).position, {3, 1, 0});
}

// A parabola in time through keys at uneven times is followed exactly inside, since the slopes are
// the parabola's own; and so its speed has no jumps.
TEST(CameraPath, FollowsAParabolaThroughUnevenKeys)
{
    const auto at = [](double t) { return glm::dvec3(t, 2 - t * t, 0.5 * t * t + t); };
    std::vector<CameraKey> path;
    for (const double t : {0.0, 0.7, 1.0, 2.5, 3.0, 4.0})
        path.push_back(key(t, at(t)));
    for (double t = 0.7; t <= 3.0; t += 0.05)
        expect_near(camera_at(path, t).position, at(t));
    const std::vector<CameraKey> straight{key(0, {0, 0, 0}, 20), key(2, {4, 0, 0}, 40)};
    expect_near(camera_at(straight, 0.5).position, {1, 0, 0});
    EXPECT_NEAR(camera_at(straight, 0.5).vfov_deg, 25, 1e-12);
}

TEST(Sequence, HashesBecomeTheFramesNumber)
{
    EXPECT_EQ(frame_file("a/smoke_####.vdb", 7), "a/smoke_0007.vdb");
    EXPECT_EQ(frame_file("smoke_##.vdb", 1234), "smoke_1234.vdb");
    EXPECT_EQ(frame_file("#_####.vdb", 3), "#_0003.vdb");
    EXPECT_EQ(frame_file("smoke.vdb", 3), "smoke.vdb");
    EXPECT_EQ(frame_file("a#b/smoke.vdb", 3), "a#b/smoke.vdb") << "a folder is no sequence";
    EXPECT_TRUE(is_sequence("x/#.vdb"));
    EXPECT_FALSE(is_sequence("x#/a.vdb"));
}

TEST(Sequence, PlacesForANumberAsOtherProgramsWriteThem)
{
    for (const auto& [pattern, file] :
         std::vector<std::pair<const char*, const char*>>{{"a.%04d.vdb", "a.0007.vdb"},
                                                          {"a.%d.vdb", "a.7.vdb"},
                                                          {"a.%3d.vdb", "a.007.vdb"},
                                                          {"a.$F4.vdb", "a.0007.vdb"},
                                                          {"a.$F.vdb", "a.7.vdb"},
                                                          {"a.${F3}.vdb", "a.007.vdb"},
                                                          {"a.@@@@.vdb", "a.0007.vdb"},
                                                          {"a@home_##.vdb", "a@home_07.vdb"},
                                                          {"take_#_%02d.vdb", "take_7_%02d.vdb"}}) {
        EXPECT_TRUE(has_frame_number(pattern)) << pattern;
        EXPECT_EQ(frame_file(pattern, 7), file) << pattern;
    }
    for (const char* plain : {"a.vdb", "100%.vdb", "5%_density.vdb", "US$.vdb", "%99999d.vdb"})
        EXPECT_FALSE(has_frame_number(plain)) << plain;
}

TEST(Sequence, AFileOfExactlyThatNameIsNoSequence)
{
    const test::TempFolder folder;
    folder.write("take#2.vdb", "x");
    folder.write("take32.vdb", "x");
    EXPECT_FALSE(is_sequence(folder.path() / "take#2.vdb"));
    EXPECT_EQ(frame_file(folder.path() / "take#2.vdb", 3), folder.path() / "take#2.vdb");
    EXPECT_TRUE(is_sequence(folder.path() / "take#3.vdb"));
    EXPECT_EQ(numbered_file(folder.path() / "take#2.vdb", 3), folder.path() / "take32.vdb");
}

TEST(Sequence, FramesBeforeZeroHaveASign)
{
    const test::TempFolder folder;
    for (const char* name : {"s.-002.vdb", "s.-0001.vdb", "s.0000.vdb", "s.0001.vdb"})
        folder.write(name, "x");
    const fs::path pattern = folder.path() / "s.####.vdb";
    EXPECT_THAT(frames_of(pattern), testing::ElementsAre(-2, -1, 0, 1));
    EXPECT_EQ(frame_file(pattern, -2).filename(), "s.-002.vdb");
    EXPECT_EQ(frame_file(pattern, -1).filename(), "s.-0001.vdb");
    EXPECT_EQ(frame_file(pattern, -3).filename(), "s.-003.vdb");
}

TEST(Sequence, FramesThatAreThereAreFound)
{
    const test::TempFolder folder;
    for (const char* name : {"s_0003.vdb", "s_0011.vdb", "s_12345.vdb", "s_003.vdb", "s_x.vdb",
                             "s_0004.vdb.tmp", "t_0005.vdb"})
        std::ofstream(folder.path() / name) << "x";
    EXPECT_THAT(frames_of(folder.path() / "s_####.vdb"), testing::ElementsAre(3, 11, 12345));
    EXPECT_TRUE(frames_of(folder.path() / "none" / "s_####.vdb").empty());
}

TEST(Sequence, AScenesTimeCameraAndFilesAreTheFrames)
{
    Scene scene;
    scene.time = 2;
    scene.frames_per_second = 4;
    scene.camera_path = {key(0, {0, 0, 0}), key(10, {10, 0, 0})};
    GridMedium moving, still;
    moving.file = "smoke_###.vdb";
    moving.density = std::make_shared<VoxelGrid>();
    still.file = "cloud.vdb";
    still.density = moving.density;
    scene.media = {moving, still};
    const Scene now = scene_at(scene, 6);
    EXPECT_DOUBLE_EQ(now.time, 3.5);
    expect_near(now.camera.position, {3.5, 0, 0});
    EXPECT_EQ(std::get<GridMedium>(now.media[0]).file, "smoke_006.vdb");
    EXPECT_EQ(std::get<GridMedium>(now.media[0]).density, nullptr);
    EXPECT_EQ(std::get<GridMedium>(now.media[1]).density, still.density);
}

class FrameLoaderTest : public testing::Test {
protected:
    void SetUp() override
    {
        for (int frame = 1; frame <= 3; ++frame)
            fs::copy_file(fs::path(FUM_TEST_DATA) / "smoke_plume.vdb",
                          folder_.path() / fmt::format("s_{:04}.vdb", frame));
        fs::copy_file(fs::path(FUM_TEST_DATA) / "smoke_plume.vdb", folder_.path() / "still.vdb");
        GridMedium moving;
        moving.file = (folder_.path() / "s_####.vdb").string();
        GridMedium still;
        still.file = (folder_.path() / "still.vdb").string();
        scene_.media = {moving, still};
    }
    static const GridMedium& medium(const std::optional<asset::LoadedScene>& frame)
    {
        return std::get<GridMedium>(frame.value().scene.media.front());
    }
    test::TempFolder folder_;
    Scene scene_;
};

TEST_F(FrameLoaderTest, EachFrameHasItsFileAndTheRestIsReadOnce)
{
    asset::FrameLoader frames({scene_, {}}, {1, 3});
    std::shared_ptr<const VoxelGrid> moving, still;
    for (int frame = 1; frame <= 3; ++frame) {
        const asset::LoadedScene now = frames.next().value();
        const auto& a = std::get<GridMedium>(now.scene.media[0]);
        const auto& b = std::get<GridMedium>(now.scene.media[1]);
        EXPECT_EQ(a.file, (folder_.path() / fmt::format("s_{:04}.vdb", frame)).string());
        ASSERT_TRUE(a.density && b.density);
        EXPECT_NE(a.density, moving);
        EXPECT_TRUE(still == nullptr || b.density == still);
        moving = a.density;
        still = b.density;
    }
}

TEST_F(FrameLoaderTest, ABillboardsImagesAreTheFramesToo)
{
    folder_.write("b_01.ppm", "P3 1 1 255 255 0 0\n");
    folder_.write("b_02.ppm", "P3 1 1 255 0 255 0\n");
    folder_.write("pane.ppm", "P3 1 1 255 0 0 255\n");
    BillboardTransparent board;
    board.look.image_file = (folder_.path() / "b_##.ppm").string();
    QuadTransparent pane;
    pane.look.image_file = (folder_.path() / "pane.ppm").string();
    scene_.media.clear();
    scene_.transparents = {board, pane};
    asset::FrameLoader frames({scene_, {}}, {1, 2});
    std::shared_ptr<const TransparentImage> still;
    for (const glm::vec4 color : {glm::vec4(1, 0, 0, 1), glm::vec4(0, 1, 0, 1)}) {
        const Scene now = frames.next().value().scene;
        const auto& image = look_of(now.transparents[0]).image;
        ASSERT_TRUE(image && look_of(now.transparents[1]).image);
        EXPECT_EQ(image->texels, std::vector{color});
        EXPECT_EQ(look_of(now.transparents[1]).image->texels.front(), glm::vec4(0, 0, 1, 1));
        EXPECT_TRUE(still == nullptr || look_of(now.transparents[1]).image == still);
        still = look_of(now.transparents[1]).image;
    }
}

TEST_F(FrameLoaderTest, AMissingFrameIsNamedWithThoseThatAreThere)
{
    fs::remove(folder_.path() / "s_0002.vdb");
    asset::FrameLoader frames({scene_, {}}, {1, 3});
    EXPECT_NO_THROW(frames.next());
    try {
        frames.next();
        FAIL() << "nothing was said";
    } catch (const Error& error) {
        EXPECT_THAT(error.what(),
                    testing::AllOf(testing::HasSubstr("s_0002.vdb"),
                                   testing::HasSubstr("frame 2 is missing"),
                                   testing::HasSubstr("2 of "), testing::HasSubstr("the last 3")));
    }
}

TEST_F(FrameLoaderTest, AStepLeavesFramesOut)
{
    fs::remove(folder_.path() / "s_0002.vdb");
    const FrameRange range{1, 4, 2};
    EXPECT_EQ(range.count(), 2);
    asset::FrameLoader frames({scene_, {}}, range);
    EXPECT_EQ(medium(frames.next()).file, (folder_.path() / "s_0001.vdb").string());
    EXPECT_EQ(medium(frames.next()).file, (folder_.path() / "s_0003.vdb").string());
}

TEST_F(FrameLoaderTest, AMissingOrBrokenFrameIsHeldOrLeftOut)
{
    folder_.write("s_0001.vdb", "no VDB");
    fs::remove(folder_.path() / "s_0003.vdb");
    asset::FrameLoader held({scene_, {}}, {1, 3}, asset::MissingFrames::hold);
    const auto first = held.next(), second = held.next(), third = held.next();
    EXPECT_TRUE(medium(first).density->empty()) << "there is none before it";
    EXPECT_FALSE(medium(second).density->empty());
    EXPECT_EQ(medium(third).density, medium(second).density);
    EXPECT_THAT(third->notes, testing::Contains(testing::HasSubstr("frame 3 is missing")));
    EXPECT_DOUBLE_EQ(third->scene.time, 3 / 24.0);

    asset::FrameLoader skipped({scene_, {}}, {1, 3}, asset::MissingFrames::skip);
    EXPECT_FALSE(skipped.next());
    EXPECT_FALSE(medium(skipped.next()).density->empty());
    EXPECT_FALSE(skipped.next());
}

TEST_F(FrameLoaderTest, AMissingImageOfABillboardIsHeldOrLeftOutToo)
{
    folder_.write("b_2.ppm", "P3 1 1 255 255 0 0\n");
    folder_.write("b_3.ppm", "no picture");
    BillboardTransparent board;
    board.look.image_file = (folder_.path() / "b_#.ppm").string();
    board.look.blend = {Blend::Kind::factors, BlendFactor::one, BlendFactor::zero};
    scene_.transparents = {board};
    const auto look = [](const std::optional<asset::LoadedScene>& frame) {
        return look_of(frame.value().scene.transparents.at(0));
    };
    asset::FrameLoader held({scene_, {}}, {1, 3}, asset::MissingFrames::hold);
    const auto first = held.next(), second = held.next(), third = held.next();
    EXPECT_EQ(look(first).image->texels, std::vector{glm::vec4(0)}) << "there is none before it";
    EXPECT_EQ(look(first).blend.kind, Blend::Kind::alpha) << "which would be a black hole";
    EXPECT_EQ(look(second).image->texels, std::vector{glm::vec4(1, 0, 0, 1)});
    EXPECT_EQ(look(second).blend.kind, Blend::Kind::factors);
    EXPECT_EQ(look(third).image, look(second).image);
    EXPECT_EQ(medium(third).density, medium(second).density) << "all of the frame is held";
    EXPECT_THAT(third->notes, testing::Contains(testing::HasSubstr("held the one before it")));

    asset::FrameLoader skipped({scene_, {}}, {1, 3}, asset::MissingFrames::skip);
    EXPECT_FALSE(skipped.next());
    EXPECT_TRUE(look(skipped.next()).image);
    EXPECT_FALSE(skipped.next());
}

/// A fire that is lit in frame 3: the files before have an empty flame, or none.
class LitLater : public testing::Test {
protected:
    void SetUp() override
    {
        const auto voxel = [](const std::string& name, double value) {
            test::VdbGrid grid;
            grid.name = name;
            grid.voxels = {{{1, 2, 3}, glm::dvec3(value)}};
            return grid;
        };
        test::VdbGrid empty;
        empty.name = "flame";
        write(1, {});
        write(2, {voxel("density", 1), empty});
        write(3, {voxel("density", 1)});
        write(4, {voxel("density", 1), voxel("flame", 2), voxel("temperature", 3)});
        GridMedium medium;
        medium.file = (folder_.path() / "f_#.vdb").string();
        medium.emission_grid = "Flame";
        medium.emission_per_unit = glm::vec3(1);
        scene_.media = {medium};
    }
    void write(int frame, const std::vector<test::VdbGrid>& grids) const
    {
        test::write_vdb(folder_.path() / fmt::format("f_{}.vdb", frame), grids);
    }
    test::TempFolder folder_;
    Scene scene_;
};

TEST_F(LitLater, WhatAFrameLacksIsEmptyInIt)
{
    asset::settle_sequences(scene_);
    EXPECT_EQ(std::get<GridMedium>(scene_.media.front()).grid, "density");
    EXPECT_EQ(asset::first_frame_with_content(scene_), 2);
    asset::FrameLoader frames({scene_, {}}, {1, 4});
    for (int frame = 1; frame <= 4; ++frame) {
        const auto now = frames.next();
        const GridMedium& at = std::get<GridMedium>(now->scene.media.front());
        ASSERT_TRUE(at.density && at.emission) << frame;
        EXPECT_EQ(at.density->empty(), frame == 1) << frame;
        EXPECT_EQ(at.emission->empty(), frame != 4) << frame;
    }
}

// What is cold in a later frame stays in the unit of those before.
TEST(FrameLoader, TemperaturesHaveOneUnitInAllFrames)
{
    const test::TempFolder folder;
    for (const auto& [frame, kelvin] : {std::pair{1, 1500.0}, {2, 15.0}, {3, 1700.0}}) {
        test::VdbGrid density, hot;
        density.boxes = {{{0, 0, 0}, {3, 3, 3}, glm::dvec3(1)}};
        hot = density;
        hot.name = "temperature";
        hot.boxes[0].value = glm::dvec3(kelvin);
        test::write_vdb(folder.path() / fmt::format("fire.{}.vdb", frame), {density, hot});
    }
    GridMedium fire;
    fire.file = (folder.path() / "fire.#.vdb").string();
    fire.grid = "density";
    fire.temperature_grid = "temperature";
    Scene scene;
    scene.media = {fire};
    asset::FrameLoader frames({scene, {}}, {1, 3});
    for (int frame = 1; frame <= 3; ++frame) {
        const std::optional<asset::LoadedScene> loaded = frames.next();
        ASSERT_TRUE(loaded);
        const auto& medium = std::get<GridMedium>(loaded->scene.media[0]);
        ASSERT_TRUE(medium.temperature);
        EXPECT_EQ(medium.temperature_scale, 1) << frame;
        EXPECT_EQ(glows_hot(medium), frame != 2) << frame;
        EXPECT_EQ(loaded->notes.size(), frame == 1 ? 1u : 0u) << "said once";
    }
    const Scene first = asset::load_frame(scene, 1, scene).scene;
    const Scene second = asset::load_frame(scene, 2, first).scene;
    EXPECT_EQ(std::get<GridMedium>(second.media[0]).temperature_scale, 1) << "as the window does";
}

TEST_F(LitLater, WhatNoFrameHasIsAMistake)
{
    std::get<GridMedium>(scene_.media.front()).emission_grid = "fire";
    try {
        asset::settle_sequences(scene_);
        FAIL() << "nothing was said";
    } catch (const Error& error) {
        EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr("no frame has a grid 'fire'"),
                                                 testing::HasSubstr("'temperature'")));
    }
}

}  // namespace
}  // namespace fumarole
