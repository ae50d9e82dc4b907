// What a .vdb's grids are taken for: the list, the rules, and a document whose grids are switched.

#include <chrono>
#include <gmock/gmock.h>
#include <thread>

#include "support/make_vdb.h"
#include "support/temp_folder.h"
#include "window/document.h"
#include "window/grid_roles.h"
#include <fumarole/asset/scene_file.h>
#include <fumarole/asset/vdb_file.h>
#include <fumarole/errors.h>

namespace fumarole::window {
namespace {

using test::TempFolder;
using test::VdbGrid;
using testing::ElementsAre;
using testing::HasSubstr;

/// A box of one value.
VdbGrid block(const std::string& name, double value, VdbGrid::Type type = VdbGrid::Type::float32)
{
    VdbGrid grid;
    grid.name = name;
    grid.type = type;
    grid.grid_class = "unknown";
    grid.world_from_index = glm::dmat4(0.1);
    grid.world_from_index[3][3] = 1;
    grid.boxes = {{{0, 0, 0}, {15, 15, 15}, glm::dvec3(value, 0.5 * value, 0.25 * value)}};
    return grid;
}

/// A smoke, a second one of another range, a flame, a heat, a colour of two kinds, and a mask.
std::filesystem::path write_all(const TempFolder& folder, const std::string& name = "all.vdb")
{
    const auto file = folder.path() / name;
    test::write_vdb(file, {block("density", 1), block("smoke2", 50), block("flame", 2),
                           block("temperature", 2), block("Cd", 0.8, VdbGrid::Type::vec3s),
                           block("tint.x", 0.5), block("tint.y", 0.25), block("tint.z", 1),
                           block("inside", 1, VdbGrid::Type::boolean)});
    return file;
}

std::vector<GridRow> rows_of(const std::filesystem::path& file)
{
    return grid_rows(asset::inspect_vdb(file), true);
}

GridMedium& medium_of(Document& document)
{
    return std::get<GridMedium>(document.scene().media.at(0));
}

/// Takes what is read until nothing more is under way.
Change settle(Document& document)
{
    Change change = Change::none;
    for (int i = 0;
         i < 6000 && (!document.whole() || document.loading() || document.grids().busy() || i == 0);
         ++i) {
        include(change, document.take_loaded());
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    include(change, document.take_loaded());
    return change;
}

command::SceneInput input(const std::filesystem::path& file)
{
    return {.file = file.string(), .size = "", .grid = "", .up = "auto"};
}

std::string role_in(Document& document, const std::string& grid)
{
    const std::vector<GridRow>& rows = document.grids().lists().at(0).rows;
    const auto row = find_row(rows, grid);
    return row ? roles_text(roles_of(medium_of(document), rows, *row)) : "not listed";
}

TEST(GridRows, AreTheFilesGridsWithVectorsOfThreeAsOne)
{
    const TempFolder folder;
    const std::vector<GridRow> rows = rows_of(write_all(folder));
    std::vector<std::string> names;
    for (const GridRow& row : rows)
        names.push_back(row.name);
    EXPECT_THAT(names,
                ElementsAre("density", "smoke2", "flame", "temperature", "Cd", "tint", "inside"));
    EXPECT_EQ(rows[0].voxels, 4096u);
    EXPECT_EQ(rows[0].type, "float");
    EXPECT_EQ(rows[1].range, std::pair(50.0, 50.0));
    EXPECT_EQ(rows[4].channels, 3);
    EXPECT_EQ(rows[5].type, "3 x float");
    EXPECT_EQ(rows[5].channels, 3);
    for (const GridRole role : grid_roles()) {
        const bool scalar = role != GridRole::color, vector = role != GridRole::temperature;
        EXPECT_EQ(role_refusal(rows[0], role).empty(), scalar) << role_name(role);
        EXPECT_EQ(role_refusal(rows[4], role).empty(), vector) << role_name(role);
        EXPECT_EQ(role_refusal(rows[5], role).empty(), vector) << role_name(role);
        EXPECT_EQ(role_refusal(rows[6], role).empty(), role == GridRole::off) << role_name(role);
        EXPECT_EQ(find_role(std::string(role_name(role))), role);
    }
    EXPECT_THROW(find_role("glow"), Error);
}

TEST(GridRoles, OneGridIsOneThingAndOneThingIsOneGrid)
{
    const TempFolder folder;
    const std::vector<GridRow> rows = rows_of(write_all(folder));
    const auto row = [&](const char* name) { return find_row(rows, name).value(); };
    GridMedium medium;
    medium.grid = "Density";  // whose case is another
    medium.sigma_s_per_density = {4, 6, 10};
    medium.emission_grid = "flame";
    medium.emission_per_unit = {3, 1, 0};
    EXPECT_THAT(roles_of(medium, rows, row("density")), ElementsAre(GridRole::density));

    RoutedMedium routed = with_role(medium, rows, row("temperature"), GridRole::emission, {});
    EXPECT_EQ(routed.medium.emission_grid, "temperature");
    EXPECT_TRUE(routed.fit.emission);
    EXPECT_FALSE(routed.fit.density);
    EXPECT_EQ(routed.medium.grid, "density");
    EXPECT_THAT(roles_of(routed.medium, rows, row("flame")), ElementsAre());

    // The smoke becomes the flame: no density is left, but where the medium is stays known.
    routed = with_role(medium, rows, row("density"), GridRole::emission, {});
    EXPECT_EQ(routed.medium.emission_grid, "density");
    EXPECT_EQ(routed.medium.grid, "density");
    EXPECT_EQ(routed.medium.sigma_s_per_density, glm::vec3(0));
    EXPECT_THAT(roles_of(routed.medium, rows, row("density")), ElementsAre(GridRole::emission));

    // What was on comes back as it was.
    RoleMemory memory;
    remember_parts(memory, medium);
    routed = with_role(medium, rows, row("flame"), GridRole::off, memory);
    EXPECT_EQ(routed.medium.emission_grid, "");
    EXPECT_EQ(routed.medium.emission_per_unit, glm::vec3(0)) << "or no scene file would be valid";
    routed = with_role(routed.medium, rows, row("flame"), GridRole::emission, memory);
    EXPECT_EQ(routed.medium.emission_per_unit, glm::vec3(3, 1, 0));
    EXPECT_FALSE(routed.fit.emission);

    // A flame that is its own smoke is two things, until it is told to be one.
    medium.emission_grid = "density";
    EXPECT_EQ(roles_text(roles_of(medium, rows, row("density"))), "density + emission");
    EXPECT_EQ(with_role(medium, rows, row("density"), GridRole::density, {}).medium.emission_grid,
              "");
}

TEST(GridRoles, ADocumentTakesItsGridsForWhatItIsToldAndSavesIt)
{
    const TempFolder folder;
    Document document(input(write_all(folder)));
    settle(document);
    ASSERT_TRUE(document.whole());
    EXPECT_TRUE(document.untouched());
    EXPECT_EQ(role_in(document, "density"), "density");
    EXPECT_EQ(role_in(document, "flame"), "emission");
    EXPECT_EQ(role_in(document, "Cd"), "colour");
    EXPECT_EQ(role_in(document, "temperature"), "off");
    const GridMedium first = medium_of(document);

    medium_of(document).g = -0.4f;  // an edit, which stays
    document.give_role(0, "smoke2", GridRole::density);
    document.give_role(0, "flame", GridRole::off);
    document.give_role(0, "temperature", GridRole::temperature);
    document.give_role(0, "tint", GridRole::color);
    EXPECT_TRUE(document.loading());
    EXPECT_EQ(settle(document), Change::content);
    const GridMedium& now = medium_of(document);
    EXPECT_EQ(document.grids().lists()[0].error, "");
    EXPECT_EQ(now.grid, "smoke2");
    EXPECT_EQ(now.density->max_value, 50);
    EXPECT_EQ(now.emission, nullptr);
    EXPECT_EQ(now.color->channels, 3);
    EXPECT_EQ(now.temperature->max_value, 2);
    EXPECT_EQ(now.temperature_scale, 1000);
    EXPECT_EQ(now.g, -0.4f);
    // Fifty times as much of it is as opaque at a fiftieth of the coefficient.
    const float ratio = (first.sigma_s_per_density.x + first.sigma_a_per_density.x) /
                        (now.sigma_s_per_density.x + now.sigma_a_per_density.x);
    EXPECT_NEAR(ratio, 50, 0.5);
    EXPECT_GT(now.blackbody_intensity, 0);
    EXPECT_NE(now.blackbody_intensity, 1) << "1 is MW/m^2/sr";
    medium_of(document).g = first.g;
    EXPECT_FALSE(document.untouched()) << "a command line of the file alone would not draw this";
    // A reset goes back to what the parts began with.
    EXPECT_EQ(std::get<GridMedium>(document.as_read().media[0]).sigma_s_per_density,
              now.sigma_s_per_density);

    const auto saved = folder.path() / "saved.json";
    asset::save_scene(document.scene(), saved);
    const asset::LoadedScene again = asset::load_scene(saved);
    const auto& read = std::get<GridMedium>(again.scene.media[0]);
    EXPECT_EQ(parts_of(read), parts_of(now));
    EXPECT_EQ(read.blackbody_intensity, now.blackbody_intensity);
    EXPECT_EQ(read.sigma_s_per_density, now.sigma_s_per_density);
    EXPECT_EQ(read.density->max_value, 50);
}

TEST(GridRoles, WhatWasSwitchedOffComesBackAndThenTheSceneIsTheFilesAgain)
{
    const TempFolder folder;
    Document document(input(write_all(folder)));
    settle(document);
    const GridMedium first = medium_of(document);
    medium_of(document).emission_per_unit *= 2;  // which the panel shows as fire x 2
    for (const char* grid : {"density", "flame", "Cd"})
        document.give_role(0, grid, GridRole::off);
    settle(document);
    EXPECT_TRUE(parts_of(medium_of(document)).empty());
    const auto saved = folder.path() / "nothing.json";
    asset::save_scene(document.scene(), saved);
    EXPECT_TRUE(parts_of(std::get<GridMedium>(asset::load_scene(saved).scene.media[0])).empty());
    document.give_role(0, "density", GridRole::density);
    document.give_role(0, "flame", GridRole::emission);
    document.give_role(0, "Cd", GridRole::color);
    settle(document);
    EXPECT_EQ(medium_of(document).emission_per_unit, first.emission_per_unit * 2.0f);
    EXPECT_EQ(std::get<GridMedium>(document.as_read().media[0]).emission_per_unit,
              first.emission_per_unit);
    medium_of(document).emission_per_unit = first.emission_per_unit;
    EXPECT_EQ(parts_of(medium_of(document)), parts_of(first));
    EXPECT_EQ(medium_of(document).sigma_s_per_density, first.sigma_s_per_density);
    EXPECT_TRUE(document.untouched());
}

TEST(GridRoles, WhatCannotBeIsSaidInTheListAndChangesNothing)
{
    const TempFolder folder;
    const auto file = write_all(folder);
    Document document(input(file));
    settle(document);
    const GridMedium first = medium_of(document);
    const auto error = [&] { return document.grids().lists()[0].error; };
    document.give_role(0, "density", GridRole::color);
    EXPECT_THAT(error(), HasSubstr("three numbers a voxel"));
    document.give_role(0, "Cd", GridRole::temperature);
    EXPECT_THAT(error(), HasSubstr("'Cd' can't be the temperature"));
    document.give_role(0, "inside", GridRole::density);
    EXPECT_THAT(error(), HasSubstr("inside"));
    document.give_role(0, "heat", GridRole::density);
    EXPECT_THAT(error(), HasSubstr("no grid 'heat' (has: density, smoke2"));
    EXPECT_THROW(document.give_role(1, "density", GridRole::off), Error);
    // Known from its header, and gone when it is wanted.
    std::filesystem::remove(file);
    document.give_role(0, "smoke2", GridRole::density);
    EXPECT_EQ(error(), "") << "it is being read";
    settle(document);
    EXPECT_THAT(error(), HasSubstr("all.vdb"));
    EXPECT_EQ(medium_of(document), first);
    EXPECT_TRUE(document.untouched());
}

TEST(GridRoles, ASequenceIsSwitchedInAllOfItsFrames)
{
    const TempFolder folder;
    for (int frame = 1; frame <= 3; ++frame) {
        std::vector<VdbGrid> grids{block("density", 1), block("heat", 0.5 * frame)};
        if (frame == 1)
            grids.pop_back();  // it is not lit yet
        test::write_vdb(folder.path() / ("fire_" + std::to_string(frame) + ".vdb"), grids);
    }
    Document document(input(folder.path() / "fire_#.vdb"));
    settle(document);
    ASSERT_TRUE(document.sequence().moves());
    document.sequence().playback().loop = false;
    document.give_role(0, "heat", GridRole::emission);
    document.give_role(0, "density", GridRole::off);
    EXPECT_EQ(settle(document), Change::content);
    EXPECT_EQ(document.grids().lists()[0].error, "");
    ASSERT_NE(medium_of(document).emission, nullptr);
    EXPECT_TRUE(medium_of(document).emission->empty()) << "of frame 1";
    EXPECT_GT(medium_of(document).emission_per_unit.x, 0) << "by the fullest frame";
    EXPECT_FALSE(document.sequence().playback().loop) << "the playhead is as it was";
    document.sequence().playback().scrub(3);
    Change change = Change::none;
    for (int i = 0; i < 3000 && change == Change::none; ++i) {
        change = document.play(0);
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    EXPECT_EQ(change, Change::frame);
    ASSERT_NE(medium_of(document).emission, nullptr);
    EXPECT_FLOAT_EQ(medium_of(document).emission->max_value, 1.5f);
    EXPECT_EQ(medium_of(document).sigma_s_per_density, glm::vec3(0));
    EXPECT_EQ(std::get<GridMedium>(document.as_read().media[0]).emission_grid, "heat");
}

}  // namespace
}  // namespace fumarole::window
