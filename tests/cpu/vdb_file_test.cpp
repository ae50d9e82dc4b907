// The .vdb reader against OpenVDB's own answers, the facts known of the samples, and files made to
// break it.

#include <fumarole/asset/vdb_file.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <limits>
#include <ostream>
#include <random>
#include <string>
#include <vector>

#include "support/make_vdb.h"
#include "support/temp_folder.h"
#include <fumarole/errors.h>
#include <fumarole/voxel_grid.h>

namespace fumarole {
namespace {

using asset::inspect_vdb;
using asset::load_grid;
using asset::LoadedGrid;
using test::openvdb_values;
using test::TempFolder;
using test::VdbCompression;
using test::VdbGrid;
using test::write_vdb;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

std::filesystem::path sample(const std::string& name)
{
    return std::filesystem::path(FUM_TEST_DATA) / name;
}

/// The message that loading or inspecting throws, or "" and a failure.
std::string error_of(const std::function<void()>& action)
{
    try {
        action();
    } catch (const Error& e) {
        return e.what();
    }
    ADD_FAILURE() << "no Error was thrown";
    return "";
}

std::string load_error(const std::filesystem::path& file, const std::string& name = "")
{
    return error_of([&] { load_grid(file, name); });
}

/// All indices of a box, and `rim` voxels around it.
std::vector<glm::ivec3> indices_of(glm::ivec3 lo, glm::ivec3 hi, int rim = 2)
{
    std::vector<glm::ivec3> indices;
    for (int z = lo.z - rim; z <= hi.z + rim; ++z)
        for (int y = lo.y - rim; y <= hi.y + rim; ++y)
            for (int x = lo.x - rim; x <= hi.x + rim; ++x)
                indices.emplace_back(x, y, z);
    return indices;
}

/// Every voxel is what OpenVDB finds there, and what VoxelGrid promises is kept.
void expect_same_as_openvdb(const VoxelGrid& grid, const std::filesystem::path& file,
                            const std::vector<glm::ivec3>& indices, bool as_fog = false)
{
    const std::vector<glm::dvec3> expected = openvdb_values(file, grid.name, indices, as_fog);
    const VoxelLookup lookup(grid);
    for (std::size_t i = 0; i < indices.size(); ++i)
        ASSERT_EQ(lookup.value(indices[i]), glm::vec3(expected[i]))
            << "voxel " << indices[i].x << " " << indices[i].y << " " << indices[i].z << " of "
            << file << " '" << grid.name << "'";
}

void expect_well_formed(const VoxelGrid& grid)
{
    ASSERT_EQ(grid.values.size(), grid.bricks.size() * 512 * std::size_t(grid.channels));
    glm::ivec3 lo(std::numeric_limits<int>::max()), hi(std::numeric_limits<int>::min());
    float max_value = 0;
    for (std::size_t b = 0; b < grid.bricks.size(); ++b) {
        const glm::ivec3 brick = grid.bricks[b];
        if (b > 0) {
            const glm::ivec3 before = grid.bricks[b - 1];
            EXPECT_LT(std::tie(before.z, before.y, before.x), std::tie(brick.z, brick.y, brick.x))
                << "bricks " << b - 1 << " and " << b << " are out of order";
        }
        bool any = false;
        for (int v = 0; v < 512; ++v)
            for (int c = 0; c < grid.channels; ++c) {
                const float value =
                    grid.values[(b * 512 + std::size_t(v)) * std::size_t(grid.channels) +
                                std::size_t(c)];
                ASSERT_TRUE(std::isfinite(value) && value >= 0) << "brick " << b << ": " << value;
                max_value = std::max(max_value, value);
                if (value > 0) {
                    const glm::ivec3 index = brick * 8 + glm::ivec3(v & 7, v >> 3 & 7, v >> 6);
                    lo = glm::min(lo, index);
                    hi = glm::max(hi, index);
                    any = true;
                }
            }
        EXPECT_TRUE(any) << "brick " << b << " is all 0";
        for (const VoxelTile& tile : grid.tiles)
            EXPECT_FALSE(glm::all(glm::lessThanEqual(tile.brick_min, brick)) &&
                         glm::all(glm::lessThanEqual(brick, tile.brick_max)))
                << "brick " << b << " lies in a tile";
    }
    for (const VoxelTile& tile : grid.tiles) {
        lo = glm::min(lo, tile.brick_min * 8);
        hi = glm::max(hi, tile.brick_max * 8 + 7);
        for (int c = 0; c < grid.channels; ++c) {
            EXPECT_TRUE(std::isfinite(tile.value[c]) && tile.value[c] >= 0) << tile.value[c];
            max_value = std::max(max_value, tile.value[c]);
        }
        EXPECT_NE(tile.value, glm::vec3(0)) << "a tile of 0";
    }
    EXPECT_EQ(grid.max_value, max_value);
    if (grid.empty()) {
        EXPECT_TRUE(grid.bricks.empty() && grid.tiles.empty());
    } else {
        EXPECT_EQ(grid.index_min, lo);
        EXPECT_EQ(grid.index_max, hi);
    }
}

/// Voxels and a box that becomes tiles; some inactive, with values of their own.
VdbGrid busy_grid(VdbGrid::Type type = VdbGrid::Type::float32)
{
    VdbGrid grid;
    grid.type = type;
    grid.boxes.push_back({{-24, 0, 8}, {-9, 15, 23}, {0.5, 0.25, 2}});
    std::mt19937 random(1);
    for (int i = 0; i < 400; ++i) {
        const auto coordinate = [&] { return int(random() % 40) - 20; };
        const auto number = [&] { return double(random() % 1024) / 256; };  // exact as half
        const glm::ivec3 index(coordinate(), coordinate(), coordinate());
        const glm::dvec3 value(number(), number(), number());
        grid.voxels.push_back({index, value, i % 5 != 0});
    }
    return grid;
}

/// Overwrites what follows the last occurrence of `after`, `skip` bytes on.
template <class T>
std::string forge(std::string bytes, const std::string& after, std::size_t skip, T value)
{
    const std::size_t at = bytes.rfind(after);
    EXPECT_NE(at, std::string::npos) << "no '" << after << "' in the file";
    std::memcpy(bytes.data() + at + after.size() + skip, &value, sizeof(value));
    return bytes;
}

/// The transform of a file of one grid, as it stands before the tree: buffer count, background,
/// counts of tiles and children, first origin, all of 4 bytes for a float grid.
std::string before_tree(const std::string& bytes)
{
    return "ScaleMap" + bytes.substr(bytes.rfind("ScaleMap") + 8, 120);
}

// --- What the samples are known to be -----------------------------------------------------------

TEST(VdbFile, ReadsTheSmokeSampleAsItsReportHasIt)
{
    const LoadedGrid loaded = load_grid(sample("smoke_plume.vdb"), "");
    const VoxelGrid& grid = loaded.grid;
    EXPECT_EQ(grid.name, "density");
    EXPECT_EQ(grid.channels, 1);
    EXPECT_TRUE(grid.stored_as_half);
    EXPECT_EQ(grid.active_voxels, 393196u);
    EXPECT_EQ(grid.index_min, glm::ivec3(7, 5, 7));
    EXPECT_EQ(grid.index_max, glm::ivec3(110, 110, 150));
    EXPECT_NEAR(grid.max_value, 1.13086, 1e-5);
    EXPECT_THAT(loaded.notes, IsEmpty());
    expect_well_formed(grid);
    const glm::dvec3 first = grid.world_from_index * glm::dvec4(7 - 0.5, 5 - 0.5, 7 - 0.5, 1);
    EXPECT_NEAR(first.x, -1.75, 1e-4);
    EXPECT_NEAR(first.y, -1.8214, 1e-4);
    EXPECT_NEAR(first.z, 0.25, 1e-4);
}

TEST(VdbFile, DescribesTheFireSample)
{
    const asset::VdbInfo info = inspect_vdb(sample("fire_plume.vdb"));
    EXPECT_EQ(info.file_bytes, 473765u);
    ASSERT_EQ(info.grids.size(), 3u);
    const asset::GridInfo& flame = info.grids[1];
    EXPECT_EQ(flame.name, "flame");
    EXPECT_EQ(flame.value_type, "half");
    EXPECT_EQ(flame.grid_class, "fog volume");
    EXPECT_EQ(flame.active_voxels, 4917u);
    EXPECT_EQ(flame.index_min, glm::ivec3(20, 19, 4));
    EXPECT_EQ(flame.index_max, glm::ivec3(43, 40, 53));
    EXPECT_NEAR(flame.max, 0.91309, 1e-5);
    EXPECT_NEAR(flame.mean, 0.38585, 1e-5);
    EXPECT_NEAR(flame.voxel_size.x, 0.0625, 1e-9);
    EXPECT_NEAR(flame.world_min.x, -0.75, 1e-6);
    EXPECT_NEAR(flame.world_max.z, 3.375, 1e-6);
    EXPECT_EQ(flame.refusal, "");
}

TEST(VdbFile, HeadersSayWhatTheValuesSay)
{
    for (const char* name : {"fire_plume.vdb", "smoke_plume.vdb", "cloud.vdb"}) {
        const asset::VdbInfo claimed = asset::read_vdb_headers(sample(name)),
                             measured = inspect_vdb(sample(name));
        ASSERT_EQ(claimed.grids.size(), measured.grids.size()) << name;
        EXPECT_EQ(claimed.creator, measured.creator);
        for (std::size_t i = 0; i < claimed.grids.size(); ++i) {
            const asset::GridInfo &a = claimed.grids[i], &b = measured.grids[i];
            EXPECT_EQ(a.name, b.name);
            EXPECT_EQ(a.value_type, b.value_type);
            EXPECT_EQ(a.grid_class, b.grid_class);
            EXPECT_EQ(a.active_voxels, b.active_voxels);
            EXPECT_EQ(a.index_min, b.index_min);
            EXPECT_EQ(a.index_max, b.index_max);
            EXPECT_EQ(a.world_min, b.world_min);
            EXPECT_EQ(a.world_max, b.world_max);
        }
    }
}

TEST(VdbFile, HeadersAreReadWithoutTheTrees)
{
    const TempFolder folder;
    const auto file = folder.path() / "torn.vdb";
    std::string bytes = test::read_bytes(sample("smoke_plume.vdb"));
    std::fill(bytes.end() - 900000, bytes.end() - 100, '\xff');
    folder.write("torn.vdb", bytes);
    EXPECT_EQ(asset::read_vdb_headers(file).grids.at(0).active_voxels, 393196u);
    EXPECT_NE(load_error(file, ""), "");
}

TEST(VdbFile, AFileThatSaysNothingOfItsGridsIsMeasured)
{
    const TempFolder folder;
    const auto file = folder.path() / "stream.vdb";
    test::VdbGrid grid;
    grid.voxels = {{{5, 6, 7}, glm::dvec3(1)}, {{9, 6, 7}, glm::dvec3(1)}};
    test::write_vdb_stream(file, {grid});
    EXPECT_EQ(asset::read_vdb_headers(file).grids.at(0).active_voxels, 2u);
    EXPECT_EQ(asset::read_vdb_headers(file).grids.at(0).index_max, glm::ivec3(9, 6, 7));
    test::VdbGrid empty;
    test::write_vdb(file, {empty});
    EXPECT_EQ(asset::read_vdb_headers(file).grids.at(0).active_voxels, 0u);
    test::write_vdb(file, {});
    EXPECT_TRUE(asset::read_vdb_headers(file).grids.empty());
}

TEST(VdbFile, AgreesWithOpenVdbOnEverySample)
{
    for (const char* name : {"smoke_plume.vdb", "fire_plume.vdb", "cloud.vdb",
                             "smoke_seq/smoke_0001.vdb", "smoke_seq/smoke_0008.vdb"}) {
        const VoxelGrid grid = load_grid(sample(name), "").grid;
        expect_well_formed(grid);
        expect_same_as_openvdb(grid, sample(name), indices_of(grid.index_min, grid.index_max));
    }
}

// --- Value types, compression, transforms, tiles ------------------------------------------------

struct StorageCase {
    const char* name;
    VdbGrid::Type type;
    bool half;
    VdbCompression compression;
};

void PrintTo(const StorageCase& c, std::ostream* out)
{
    *out << c.name;
}

class Storage : public testing::TestWithParam<StorageCase> {};

TEST_P(Storage, EveryVoxelIsWhatOpenVdbReads)
{
    const TempFolder folder;
    const auto file = folder.path() / "busy.vdb";
    VdbGrid made = busy_grid(GetParam().type);
    made.half = GetParam().half;
    made.grid_class = "unknown";  // or it would not be zipped
    write_vdb(file, {made}, GetParam().compression);

    const VoxelGrid grid = load_grid(file, "density").grid;
    const bool vector =
        GetParam().type == VdbGrid::Type::vec3s || GetParam().type == VdbGrid::Type::vec3d;
    EXPECT_EQ(grid.channels, vector ? 3 : 1);
    EXPECT_EQ(grid.stored_as_half, GetParam().half);
    expect_well_formed(grid);
    expect_same_as_openvdb(grid, file, indices_of({-26, -22, -22}, {22, 22, 26}));
}

INSTANTIATE_TEST_SUITE_P(
    Files, Storage,
    testing::Values(
        StorageCase{"FloatBlosc", VdbGrid::Type::float32, false, VdbCompression::blosc},
        StorageCase{"FloatZip", VdbGrid::Type::float32, false, VdbCompression::zip},
        StorageCase{"FloatRaw", VdbGrid::Type::float32, false, VdbCompression::none},
        StorageCase{"HalfBlosc", VdbGrid::Type::float32, true, VdbCompression::blosc},
        StorageCase{"HalfZip", VdbGrid::Type::float32, true, VdbCompression::zip},
        StorageCase{"HalfRaw", VdbGrid::Type::float32, true, VdbCompression::none},
        StorageCase{"DoubleBlosc", VdbGrid::Type::float64, false, VdbCompression::blosc},
        StorageCase{"DoubleAsHalfZip", VdbGrid::Type::float64, true, VdbCompression::zip},
        StorageCase{"Vec3fBlosc", VdbGrid::Type::vec3s, false, VdbCompression::blosc},
        StorageCase{"Vec3fAsHalfZip", VdbGrid::Type::vec3s, true, VdbCompression::zip},
        StorageCase{"Vec3dRaw", VdbGrid::Type::vec3d, false, VdbCompression::none}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(VdbFile, StreamsWithoutOffsetsAreRead)
{
    const TempFolder folder;
    const auto file = folder.path() / "stream.vdb";
    VdbGrid second = busy_grid();
    second.name = "flame";
    test::write_vdb_stream(file, {busy_grid(VdbGrid::Type::vec3s), second});
    const VoxelGrid grid = load_grid(file, "flame").grid;
    expect_well_formed(grid);
    EXPECT_EQ(VoxelLookup(grid).value({-20, 4, 12}).x, 0.5f);
}

struct TransformCase {
    const char* name;
    glm::dmat4 world_from_index;
};

void PrintTo(const TransformCase& c, std::ostream* out)
{
    *out << c.name;
}

class Transform : public testing::TestWithParam<TransformCase> {};

// The points are given in world space, so a transposed or mirrored matrix shows.
TEST_P(Transform, PutsTheFieldWhereOpenVdbHasIt)
{
    const TempFolder folder;
    const auto file = folder.path() / "placed.vdb";
    VdbGrid made = busy_grid();
    made.world_from_index = GetParam().world_from_index;
    write_vdb(file, {made});

    const VoxelGrid grid = load_grid(file, "").grid;
    const VoxelLookup lookup(grid);
    std::mt19937 random(2);
    std::uniform_real_distribution<double> between(-26, 26);
    std::vector<glm::dvec3> p_world;
    for (int i = 0; i < 3000; ++i)
        p_world.emplace_back(made.world_from_index *
                             glm::dvec4(between(random), between(random), between(random), 1));
    const std::vector<double> expected = test::openvdb_samples(file, "density", p_world);
    const glm::dmat4 index_from_world = glm::inverse(grid.world_from_index);
    int seen = 0;
    for (std::size_t i = 0; i < p_world.size(); ++i) {
        const double actual = lookup.sample(index_from_world * glm::dvec4(p_world[i], 1)).x;
        seen += expected[i] > 0;
        // OpenVDB interpolates in float.
        ASSERT_NEAR(actual, expected[i], 1e-5) << "point " << i;
    }
    EXPECT_GT(seen, 50) << "the points miss the field, so nothing was tested";
}

INSTANTIATE_TEST_SUITE_P(
    Maps, Transform,
    testing::Values(
        TransformCase{"Identity", glm::dmat4(1.0)},
        TransformCase{"Translated", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 3, -2, 7, 1}},
        TransformCase{"Scaled", {0.1, 0, 0, 0, 0, 0.1, 0, 0, 0, 0, 0.1, 0, 0, 0, 0, 1}},
        TransformCase{"ScaledPlaced", {0.1, 0, 0, 0, 0, 0.1, 0, 0, 0, 0, 0.1, 0, 1, 2, 3, 1}},
        TransformCase{"NonUniform", {0.1, 0, 0, 0, 0, 0.3, 0, 0, 0, 0, 2, 0, 1, 2, 3, 1}},
        TransformCase{"Mirrored", {-0.1, 0, 0, 0, 0, 0.3, 0, 0, 0, 0, 2, 0, 1, 2, 3, 1}},
        TransformCase{"Rotated", {0, 0.5, 0, 0, -0.5, 0, 0, 0, 0, 0, 0.5, 0, 4, 5, 6, 1}},
        TransformCase{"Sheared", {1, 0, 0, 0, 0.4, 1, 0, 0, -0.2, 0.3, 1, 0, 4, 5, 6, 1}},
        TransformCase{"Anything",
                      {0.3, 0.1, -0.2, 0, 0.7, -0.9, 0.05, 0, 0.1, 0.2, 0.4, 0, 1e4, -5, 6, 1}}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(VdbFile, HugeTilesStayTiles)
{
    const TempFolder folder;
    const auto file = folder.path() / "tiles.vdb";
    VdbGrid made;
    made.boxes.push_back({{0, 0, 0}, {4095, 4095, 4095}, glm::dvec3(3)});
    made.boxes.push_back({{-128, 0, 0}, {-1, 127, 127}, glm::dvec3(2)});
    made.boxes.push_back({{-136, 0, 0}, {-129, 7, 7}, glm::dvec3(1)});
    write_vdb(file, {made});

    const VoxelGrid grid = load_grid(file, "").grid;
    EXPECT_EQ(grid.bricks.size(), 0u);
    ASSERT_EQ(grid.tiles.size(), 3u);
    EXPECT_EQ(grid.active_voxels, (1ull << 36) + (1ull << 21) + (1ull << 9));
    EXPECT_EQ(grid.index_min, glm::ivec3(-136, 0, 0));
    EXPECT_EQ(grid.index_max, glm::ivec3(4095));
    expect_well_formed(grid);
    const VoxelLookup lookup(grid);
    EXPECT_EQ(lookup.value({4095, 4095, 0}).x, 3.0f);
    EXPECT_EQ(lookup.value({-1, 127, 127}).x, 2.0f);
    EXPECT_EQ(lookup.value({-130, 7, 7}).x, 1.0f);
    EXPECT_EQ(lookup.value({-130, 8, 7}).x, 0.0f);

    const asset::GridInfo info = inspect_vdb(file).grids.at(0);
    EXPECT_EQ(info.active_tiles, 3u);
    EXPECT_NEAR(info.mean, 3, 1e-3) << "tiles count by their voxels";
}

TEST(VdbFile, VoxelsFarApartTakeNoMemory)
{
    const TempFolder folder;
    const auto file = folder.path() / "far.vdb";
    VdbGrid made;
    made.voxels = {{{0, 0, 0}, glm::dvec3(1)}, {glm::ivec3(1 << 30), glm::dvec3(2)}};
    write_vdb(file, {made});
    const VoxelGrid grid = load_grid(file, "").grid;
    EXPECT_EQ(grid.bricks.size(), 2u);
    EXPECT_EQ(grid.index_max, glm::ivec3(1 << 30));
    EXPECT_EQ(VoxelLookup(grid).value(glm::ivec3(1 << 30)).x, 2.0f);
    expect_well_formed(grid);

    for (const int edge : {std::numeric_limits<int>::max(), std::numeric_limits<int>::min()}) {
        made.voxels = {{glm::ivec3(0, edge, 0), glm::dvec3(1)}};
        write_vdb(file, {made});
        EXPECT_THAT(load_error(file), HasSubstr("more than can be addressed")) << edge;
        EXPECT_EQ(inspect_vdb(file).grids.at(0).index_max.y, edge);
    }
    made.voxels = {{glm::ivec3(-(1 << 30)), glm::dvec3(1)}, {glm::ivec3(1 << 30), glm::dvec3(2)}};
    write_vdb(file, {made});
    EXPECT_THAT(load_error(file), HasSubstr("more than can be addressed")) << "2^31 apart";

    // The last tile of all that 32-bit indices hold; OpenVDB itself overflows where it writes it.
    made.voxels.clear();
    made.boxes = {{glm::ivec3(0), glm::ivec3(4095), glm::dvec3(1)}};
    write_vdb(file, {made});
    const std::string bytes = test::read_bytes(file);
    const auto last =
        folder.write("last.vdb", forge(bytes, before_tree(bytes), 16, glm::ivec3(0x7ffff000)));
    EXPECT_THAT(load_error(last), HasSubstr("more than can be addressed"));
    EXPECT_EQ(inspect_vdb(last).grids.at(0).index_max, glm::ivec3(0x7fffffff));
}

TEST(VdbFile, BricksOfZeroAreDropped)
{
    const TempFolder folder;
    const auto file = folder.path() / "zeros.vdb";
    VdbGrid made;
    made.voxels = {{{0, 0, 0}, glm::dvec3(0)},
                   {{20, 0, 0}, glm::dvec3(4)},
                   {{40, 0, 0}, glm::dvec3(0)},
                   {{60, 3, 2}, glm::dvec3(5)}};
    write_vdb(file, {made});
    const VoxelGrid grid = load_grid(file, "").grid;
    EXPECT_EQ(grid.active_voxels, 4u) << "as the file counts them";
    EXPECT_EQ(grid.bricks.size(), 2u);
    EXPECT_EQ(grid.index_min, glm::ivec3(20, 0, 0));
    EXPECT_EQ(grid.index_max, glm::ivec3(60, 3, 2));
    expect_well_formed(grid);
}

// --- Values that no medium can have -------------------------------------------------------------

TEST(VdbFile, BadValuesBecomeZeroAndAreCounted)
{
    const TempFolder folder;
    const auto file = folder.path() / "bad.vdb";
    VdbGrid made;
    made.type = VdbGrid::Type::float64;
    made.voxels = {{{0, 0, 0}, glm::dvec3(kNan)},  {{1, 0, 0}, glm::dvec3(kInf)},
                   {{2, 0, 0}, glm::dvec3(-kInf)}, {{3, 0, 0}, glm::dvec3(1e300)},
                   {{4, 0, 0}, glm::dvec3(-2)},    {{5, 0, 0}, glm::dvec3(0.5)}};
    made.boxes.push_back({{0, 16, 0}, {7, 23, 7}, glm::dvec3(-1)});
    write_vdb(file, {made});

    const LoadedGrid loaded = load_grid(file, "");
    EXPECT_THAT(loaded.notes,
                ElementsAre(AllOf(HasSubstr("bad.vdb"), HasSubstr("1 NaN value read as 0")),
                            HasSubstr("3 infinite values read as 0"),
                            HasSubstr("513 negative values read as 0")));
    expect_well_formed(loaded.grid);
    EXPECT_EQ(loaded.grid.index_min, glm::ivec3(5, 0, 0));
    EXPECT_EQ(loaded.grid.index_max, glm::ivec3(5, 0, 0));
    EXPECT_EQ(loaded.grid.max_value, 0.5f);

    const asset::GridInfo info = inspect_vdb(file).grids.at(0);
    EXPECT_EQ(info.nan_count, 1u);
    EXPECT_EQ(info.inf_count, 2u) << "1e300 is finite in the file";
    EXPECT_EQ(info.negative_count, 514u) << "512 of the tile, -2, and -inf";
    EXPECT_EQ(info.min, -2);
    EXPECT_EQ(info.max, 1e300);
}

TEST(VdbFile, BackgroundFillsTheActiveBoxAlone)
{
    const TempFolder folder;
    const auto file = folder.path() / "background.vdb";
    VdbGrid made;
    made.type = VdbGrid::Type::vec3s;
    made.background = {1, 0.5, 0.25};
    made.voxels = {{{3, 3, 3}, {9, 8, 7}}, {{40, 20, 12}, {2, 2, 2}}};
    write_vdb(file, {made});

    const LoadedGrid loaded = load_grid(file, "density");
    expect_well_formed(loaded.grid);
    EXPECT_THAT(loaded.notes, ElementsAre(HasSubstr("background (1, 0.5, 0.25)")));
    EXPECT_EQ(loaded.grid.index_min, glm::ivec3(3));
    EXPECT_EQ(loaded.grid.index_max, glm::ivec3(40, 20, 12));
    expect_same_as_openvdb(loaded.grid, file, indices_of({3, 3, 3}, {40, 20, 12}, 0));
    EXPECT_EQ(VoxelLookup(loaded.grid).value({41, 20, 12}), glm::vec3(0));

    made.voxels.push_back({{1 << 20, 0, 0}, {1, 1, 1}});  // too far apart to fill
    write_vdb(file, {made});
    EXPECT_LT(load_grid(file, "density").grid.bricks.size(), 4u);
}

TEST(VdbFile, LevelSetsBecomeTheFogThatOpenVdbMakes)
{
    const TempFolder folder;
    const auto file = folder.path() / "sphere.vdb";
    VdbGrid made;
    made.name = "surface";
    made.sphere_radius = 20;
    made.grid_class = "level set";
    write_vdb(file, {made});

    const LoadedGrid loaded = load_grid(file, "");
    EXPECT_THAT(loaded.notes, ElementsAre(HasSubstr("a level set, made into fog")));
    EXPECT_EQ(loaded.grid.max_value, 1.0f);
    EXPECT_EQ(VoxelLookup(loaded.grid).value({0, 0, 0}).x, 1.0f) << "its inside is full";
    EXPECT_EQ(VoxelLookup(loaded.grid).value({21, 0, 0}).x, 0.0f) << "its outside is empty";
    expect_well_formed(loaded.grid);

    const auto indices = indices_of(glm::ivec3(-22), glm::ivec3(22), 0);
    const auto expected = openvdb_values(file, "surface", indices, /*as_fog=*/true);
    const VoxelLookup lookup(loaded.grid);
    for (std::size_t i = 0; i < indices.size(); ++i)
        ASSERT_NEAR(lookup.value(indices[i]).x, expected[i].x, 1e-6)  // it divides in float
            << indices[i].x << " " << indices[i].y << " " << indices[i].z;
}

// --- Which grid ---------------------------------------------------------------------------------

VdbGrid one_voxel(const std::string& name, double value, const std::string& grid_class)
{
    VdbGrid grid;
    grid.name = name;
    grid.grid_class = grid_class;
    grid.voxels = {{{0, 0, 0}, glm::dvec3(value)}};
    return grid;
}

struct DefaultCase {
    const char* name;
    std::vector<VdbGrid> grids;
    const char* expected;
};

void PrintTo(const DefaultCase& c, std::ostream* out)
{
    *out << c.name;
}

class Default : public testing::TestWithParam<DefaultCase> {};

TEST_P(Default, IsTheLikeliestFog)
{
    const TempFolder folder;
    const auto file = folder.path() / "several.vdb";
    write_vdb(file, GetParam().grids);
    EXPECT_EQ(load_grid(file, "").grid.name, GetParam().expected);
}

VdbGrid sphere(const std::string& name)
{
    VdbGrid grid;
    grid.name = name;
    grid.grid_class = "level set";
    grid.sphere_radius = 5;
    return grid;
}

INSTANTIATE_TEST_SUITE_P(
    Files, Default,
    testing::Values(
        DefaultCase{"DensityFirst",
                    {one_voxel("heat", 1, "fog volume"), one_voxel("density", 1, "unknown")},
                    "density"},
        DefaultCase{
            "WhateverTheCase",
            {one_voxel("Temperature", 9, "fog volume"), one_voxel("Density", 1, "fog volume")},
            "Density"},
        DefaultCase{"SootBeforeHeat",
                    {one_voxel("heat", 1, "fog volume"), one_voxel("soot", 1, "unknown")},
                    "soot"},
        DefaultCase{"SmokeBeforeSoot",
                    {one_voxel("soot", 1, "fog volume"), one_voxel("SMOKE", 1, "fog volume")},
                    "SMOKE"},
        DefaultCase{"AWordOfTheName",
                    {one_voxel("a", 1, "fog volume"), one_voxel("voxelFogDensity", 1, "unknown")},
                    "voxelFogDensity"},
        DefaultCase{
            "TheWholeNameBeforeAWord",
            {one_voxel("density low res", 1, "fog volume"), one_voxel("density", 1, "fog volume")},
            "density"},
        DefaultCase{"AnythingBeforeFire",
                    {one_voxel("fuel", 1, "fog volume"), one_voxel("flame", 1, "fog volume"),
                     one_voxel("shadow", 1, "fog volume"), one_voxel("thing", 1, "unknown")},
                    "thing"},
        DefaultCase{"FireBeforeShadow",
                    {one_voxel("shadow", 1, "fog volume"), one_voxel("flame", 1, "fog volume")},
                    "flame"},
        DefaultCase{"FogBeforeUnknown",
                    {one_voxel("a", 1, "unknown"), one_voxel("b", 1, "fog volume")},
                    "b"},
        DefaultCase{"UnknownBeforeLevelSet", {sphere("a"), one_voxel("b", 1, "unknown")}, "b"},
        DefaultCase{"NotTheEmptyOne",
                    {one_voxel("flame", 0, "fog volume"), one_voxel("smoke", 1, "fog volume")},
                    "smoke"},
        DefaultCase{"NotTheNegativeOne",
                    {one_voxel("shadow", -1, "fog volume"), one_voxel("smoke", 1, "fog volume")},
                    "smoke"},
        DefaultCase{"FirstOfTheSameName",
                    {one_voxel("density", 1, "fog volume"), one_voxel("density", 2, "fog volume")},
                    "density[0]"},
        DefaultCase{"LevelSetAtLast", {sphere("a"), sphere("b")}, "a"},
        DefaultCase{"Unnamed", {one_voxel("", 1, "fog volume")}, "[0]"}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(VdbFile, SaysWhenTheDefaultIsNotTheObviousGrid)
{
    const TempFolder folder;
    const auto file = folder.path() / "smoke.vdb";
    write_vdb(file, {one_voxel("density", 0, "fog volume"), one_voxel("flame", 1, "fog volume")});
    EXPECT_THAT(load_grid(file, "").notes,
                ElementsAre(HasSubstr("read 'flame', for 'density' is empty")));
}

TEST(VdbFile, CaseTellsNamesApartOnlyWhereItMust)
{
    const TempFolder folder;
    const auto file = folder.path() / "case.vdb";
    write_vdb(file, {one_voxel("Density", 1, "fog volume"), one_voxel("Heat", 7, "fog volume"),
                     one_voxel("heat", 8, "fog volume"), one_voxel("Cd_R", 2, "unknown"),
                     one_voxel("Cd_G", 3, "unknown"), one_voxel("Cd_B", 4, "unknown")});
    EXPECT_EQ(load_grid(file, "density").grid.name, "Density");
    EXPECT_EQ(load_grid(file, "heat").grid.max_value, 8);
    EXPECT_EQ(load_grid(file, "HEAT").grid.max_value, 7);
    const VoxelGrid color = load_grid(file, "cd").grid;
    EXPECT_EQ(color.channels, 3);
    EXPECT_EQ(VoxelLookup(color).value({0, 0, 0}), glm::vec3(2, 3, 4));
}

TEST(VdbFile, GridsOfOneNameAreAddressedByNumber)
{
    const TempFolder folder;
    const auto file = folder.path() / "three.vdb";
    write_vdb(file, {one_voxel("density", 1, "fog volume"), one_voxel("heat", 7, "fog volume"),
                     one_voxel("density", 2, "fog volume"), one_voxel("density", 3, "fog volume")});
    const auto value = [&](const std::string& name) {
        return load_grid(file, name).grid.max_value;
    };
    EXPECT_EQ(value("density"), 1);
    EXPECT_EQ(value("density[0]"), 1);
    EXPECT_EQ(value("density[1]"), 2);
    EXPECT_EQ(value("density[2]"), 3);
    EXPECT_EQ(value("heat"), 7);
    EXPECT_THAT(load_error(file, "density[3]"), HasSubstr("no grid 'density[3]'"));
    EXPECT_EQ(inspect_vdb(file).grids.at(2).name, "density[1]");
}

TEST(VdbFile, AGridThatIsNotThereIsAnsweredWithThoseThatAre)
{
    const TempFolder folder;
    const auto file = folder.path() / "smoke.vdb";
    VdbGrid velocity = busy_grid(VdbGrid::Type::vec3s);
    velocity.name = "v";
    velocity.grid_class = "unknown";
    write_vdb(file, {one_voxel("temperature", 1, "fog volume"), velocity});
    EXPECT_EQ(load_error(file, "density"),
              file.string() +
                  ": no grid 'density' (has: 'temperature' float fog volume, 'v' vec3s)");

    write_vdb(file, {velocity});
    EXPECT_THAT(load_error(file), AllOf(HasSubstr("asked for by name"), HasSubstr("'v' vec3s")));
    write_vdb(file, {});
    EXPECT_THAT(load_error(file), HasSubstr("has no grids"));
}

TEST(VdbFile, AnEmptyGridIsAnErrorOnlyWhenNobodyNamedIt)
{
    const TempFolder folder;
    const auto file = folder.path() / "empty.vdb";
    write_vdb(file, {VdbGrid{}});
    EXPECT_THAT(load_error(file), HasSubstr("nothing above 0"));
    const LoadedGrid loaded = load_grid(file, "density");
    EXPECT_TRUE(loaded.grid.empty());
    EXPECT_THAT(loaded.notes, ElementsAre(HasSubstr("empty")));
    expect_well_formed(loaded.grid);
}

struct RefusalCase {
    const char* name;
    VdbGrid grid;
    const char* reason;
};

void PrintTo(const RefusalCase& c, std::ostream* out)
{
    *out << c.name;
}

class Refusal : public testing::TestWithParam<RefusalCase> {};

TEST_P(Refusal, NamesTheGridAndTheReason)
{
    const TempFolder folder;
    const auto file = folder.path() / "refused.vdb";
    VdbGrid made = GetParam().grid;
    made.name = "odd";
    made.voxels = {{{1, 2, 3}, glm::dvec3(1)}};
    write_vdb(file, {made});
    EXPECT_THAT(load_error(file, "odd"),
                AllOf(HasSubstr("refused.vdb"), HasSubstr("'odd'"), HasSubstr(GetParam().reason)));
    EXPECT_THAT(load_error(file), HasSubstr("'odd'"));
    const asset::GridInfo info = inspect_vdb(file).grids.at(0);
    EXPECT_THAT(info.refusal, HasSubstr(GetParam().reason));
    EXPECT_EQ(info.active_voxels, 1u);
    EXPECT_EQ(info.index_min, glm::ivec3(1, 2, 3));
}

VdbGrid of_type(VdbGrid::Type type)
{
    VdbGrid grid;
    grid.type = type;
    return grid;
}

VdbGrid in_a_frustum()
{
    VdbGrid grid;
    grid.frustum = true;
    return grid;
}

INSTANTIATE_TEST_SUITE_P(Grids, Refusal,
                         testing::Values(RefusalCase{"Bool", of_type(VdbGrid::Type::boolean),
                                                     "bool"},
                                         RefusalCase{"Int", of_type(VdbGrid::Type::int32), "int32"},
                                         RefusalCase{"Mask", of_type(VdbGrid::Type::mask), "mask"},
                                         RefusalCase{"Frustum", in_a_frustum(), "frustum"}),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(VdbFile, AnInstanceSharesTheValuesButNotThePlace)
{
    const TempFolder folder;
    const auto file = folder.path() / "instance.vdb";
    VdbGrid first = busy_grid(), second;
    second.name = "copy";
    second.shares_tree_with = 0;
    second.world_from_index[3] = {100, 0, 0, 1};
    write_vdb(file, {first, second});
    const VoxelGrid a = load_grid(file, "density").grid, b = load_grid(file, "copy").grid;
    EXPECT_EQ(a.values, b.values);
    EXPECT_EQ(b.world_from_index[3].x, 100);
    const asset::VdbInfo info = inspect_vdb(file);
    EXPECT_EQ(info.grids.at(1).active_voxels, info.grids.at(0).active_voxels);
    EXPECT_EQ(info.grids.at(1).world_min.x, info.grids.at(0).world_min.x + 100);
}

// --- Channels -----------------------------------------------------------------------------------

TEST(VdbFile, ThreeChannelsBecomeOneGrid)
{
    const TempFolder folder;
    const auto file = folder.path() / "rgb.vdb";
    std::vector<VdbGrid> channels(3);
    for (int c = 0; c < 3; ++c) {
        VdbGrid& grid = channels[std::size_t(c)];
        grid.name = std::string("color.") + "xyz"[c];
        grid.voxels = {{{2, 3, 4}, glm::dvec3(c + 1)}};
    }
    // A tile of one channel where another has a voxel, and where none has.
    channels[1].boxes = {{{0, 0, 128}, {127, 127, 255}, glm::dvec3(7)}};
    channels[2].boxes = {{{0, 0, 128}, {127, 127, 255}, glm::dvec3(8)}};
    channels[0].voxels.push_back({{-5, 0, 0}, glm::dvec3(4)});
    channels[0].voxels.push_back({{100, 100, 200}, glm::dvec3(6)});
    write_vdb(file, channels);

    const LoadedGrid loaded = load_grid(file, "color");
    const VoxelGrid& grid = loaded.grid;
    EXPECT_EQ(grid.name, "color");
    EXPECT_EQ(grid.channels, 3);
    expect_well_formed(grid);
    EXPECT_LT(grid.bricks.size() + grid.tiles.size(), 40u) << "the tile was cut to crumbs";
    const VoxelLookup lookup(grid);
    EXPECT_EQ(lookup.value({2, 3, 4}), glm::vec3(1, 2, 3));
    EXPECT_EQ(lookup.value({-5, 0, 0}), glm::vec3(4, 0, 0));
    EXPECT_EQ(lookup.value({100, 100, 200}), glm::vec3(6, 7, 8));
    for (const glm::ivec3 index : indices_of({90, 90, 190}, {110, 110, 210}, 0)) {
        const glm::vec3 expected(index == glm::ivec3(100, 100, 200) ? 6 : 0, 7, 8);
        ASSERT_EQ(lookup.value(index), expected) << index.x << " " << index.y << " " << index.z;
    }
    EXPECT_EQ(lookup.value({0, 0, 128}), glm::vec3(0, 7, 8));
    EXPECT_EQ(lookup.value({127, 127, 255}), glm::vec3(0, 7, 8));
    EXPECT_EQ(lookup.value({128, 127, 255}), glm::vec3(0));
}

TEST(VdbFile, ChannelsInDifferentPlacesAreRefused)
{
    const TempFolder folder;
    const auto file = folder.path() / "rgb.vdb";
    std::vector<VdbGrid> channels = {one_voxel("c.x", 1, "unknown"), one_voxel("c.y", 1, "unknown"),
                                     one_voxel("c.z", 1, "unknown")};
    channels[2].world_from_index[3].x = 1;
    write_vdb(file, channels);
    EXPECT_THAT(load_error(file, "c"), HasSubstr("different transforms"));
    channels.pop_back();
    write_vdb(file, channels);
    EXPECT_THAT(load_error(file, "c"), HasSubstr("no grid 'c'")) << "one of three is missing";
}

// --- Files that are no .vdb, or no whole one ----------------------------------------------------

TEST(VdbFile, WhatIsNoVdbIsNamed)
{
    const TempFolder folder;
    EXPECT_THAT(load_error(folder.path() / "none.vdb"), HasSubstr("none.vdb: no such file"));
    EXPECT_THAT(load_error(folder.path()), HasSubstr("not a file"));
    EXPECT_THAT(load_error("/dev/zero"), HasSubstr("not a file"));
    EXPECT_THAT(load_error(folder.write("a.vdb", "")), HasSubstr("a.vdb: not an OpenVDB file"));
    EXPECT_THAT(load_error(folder.write("b.vdb", "a picture, more likely")),
                HasSubstr("b.vdb: not an OpenVDB file"));
    EXPECT_THAT(load_error(folder.write("c.vdb", "NanoVDB0........")),
                HasSubstr("c.vdb: NanoVDB "));
    const auto sparse = folder.write("sparse.vdb", "x");
    std::filesystem::resize_file(sparse, std::uintmax_t(1) << 42);
    EXPECT_THAT(load_error(sparse), HasSubstr("too large"));
}

/// Loads and inspects; an Error must name the file. Everything else fails the test by itself.
/// Returns whether it was read.
bool survives(const std::filesystem::path& file, const std::string& about)
{
    const auto try_it = [&](const std::function<void()>& action) {
        try {
            action();
            return true;
        } catch (const Error& e) {
            EXPECT_THAT(e.what(), HasSubstr(file.filename().string())) << about;
            return false;
        }
    };
    const bool loaded = try_it([&] { expect_well_formed(load_grid(file, "").grid); });
    try_it([&] { inspect_vdb(file); });
    // Some file systems wait for the disk when a file is overwritten, hundreds of times here.
    std::filesystem::remove(file);
    return loaded;
}

std::vector<VdbGrid> small_file()
{
    VdbGrid grid;
    grid.grid_class = "unknown";  // or it would not be zipped
    grid.voxels = {
        {{1, 2, 3}, glm::dvec3(1)}, {{4, 5, 6}, glm::dvec3(2)}, {{9, 0, 0}, glm::dvec3(3)}};
    grid.boxes = {{{16, 0, 0}, {31, 7, 7}, glm::dvec3(2)},
                  {{4096, 0, 0}, {8191, 4095, 4095}, glm::dvec3(1)}};
    VdbGrid level_set = sphere("surface");
    level_set.sphere_radius = 3;
    return {grid, level_set};
}

class Damage : public testing::TestWithParam<VdbCompression> {};

TEST_P(Damage, AFileCutAnywhereIsAnError)
{
    const TempFolder folder;
    const auto file = folder.path() / "cut.vdb";
    write_vdb(file, small_file(), GetParam());
    const std::string bytes = test::read_bytes(file);
    // Every length near the ends, where headers and trailers are, and a sample between.
    for (std::size_t size = 0; size < bytes.size();
         size += size < 700 || size + 300 > bytes.size() ? 1 : 97) {
        const auto cut = folder.write("cut.vdb", std::string_view(bytes).substr(0, size));
        EXPECT_FALSE(survives(cut, "")) << size << " of " << bytes.size() << " bytes were read";
    }
}

TEST_P(Damage, FlippedBytesNeverDoWorseThanAnError)
{
    const TempFolder folder;
    const auto file = folder.path() / "flipped.vdb";
    write_vdb(file, small_file(), GetParam());
    const std::string bytes = test::read_bytes(file);
    std::mt19937 random(3);
    for (int i = 0; i < 600; ++i) {
        std::string flipped = bytes;
        for (int n = 0; n < 1 + i % 3; ++n)
            flipped[random() % flipped.size()] = char(random() % 4 ? random() : 0xff);
        survives(folder.write("flipped.vdb", flipped), "round " + std::to_string(i));
    }
}

INSTANTIATE_TEST_SUITE_P(
    Compression, Damage,
    testing::Values(VdbCompression::none, VdbCompression::zip, VdbCompression::blosc),
    [](const auto& test) {
        return std::string(std::array{"Raw", "Zip", "Blosc"}[std::size_t(test.param)]);
    });

TEST(VdbFile, AZipChunkWithABadChecksumIsAnError)
{
    const TempFolder folder;
    const auto file = folder.path() / "flipped.vdb";
    VdbGrid made;  // one leaf, its 512 values the last chunk of the file
    made.grid_class = "unknown";
    made.boxes = {{{0, 0, 0}, {7, 7, 7}, glm::dvec3(1)}};
    made.voxels = {{{0, 0, 0}, glm::dvec3(2)}};
    write_vdb(file, {made}, VdbCompression::zip);
    std::string bytes = test::read_bytes(file);
    bytes.back() = char(bytes.back() ^ 1);  // of the chunk's Adler-32
    EXPECT_THAT(load_error(folder.write("flipped.vdb", bytes)), HasSubstr("don't expand"));
}

TEST(VdbFile, ForgedSizesAreRefusedBeforeTheyAreBelieved)
{
    const TempFolder folder;
    const auto file = folder.path() / "forged.vdb";
    VdbGrid made;
    made.grid_class = "unknown";  // or it would not be zipped
    made.voxels = {{{0, 0, 0}, glm::dvec3(2)}};
    write_vdb(file, {made}, VdbCompression::zip);
    const std::string bytes = test::read_bytes(file);
    // The last chunk: 8 bytes of size, then 4 of the one active value, not worth compressing.
    const std::int64_t size_of_last = -4;
    std::int64_t stored;
    std::memcpy(&stored, bytes.data() + bytes.size() - 12, 8);
    ASSERT_EQ(stored, size_of_last) << "the file is not as this test takes it to be";
    for (const std::int64_t lie :
         {std::int64_t(-5), std::int64_t(-4096), std::int64_t(0), std::int64_t(1) << 40,
          std::numeric_limits<std::int64_t>::max(), std::numeric_limits<std::int64_t>::min()}) {
        std::string forged = bytes;
        std::memcpy(forged.data() + forged.size() - 12, &lie, 8);
        EXPECT_THAT(load_error(folder.write("forged.vdb", forged)),
                    HasSubstr(lie > 0 ? "runs past the end" : "where 4 belong"))
            << "a chunk of " << lie << " bytes";
    }

    // Metadata that lies: a length of 4 GB, and a box and a count that have nothing to do with it.
    EXPECT_THAT(load_error(folder.write("forged.vdb", forge(bytes, "file_bbox_min", 0, ~0u))),
                HasSubstr("damaged"));
    std::string lying = forge(bytes, std::string("file_bbox_max\5\0\0\0vec3i", 22), 4, 1 << 30);
    lying =
        forge(lying, std::string("file_voxel_count\5\0\0\0int64", 25), 4, std::int64_t(1) << 60);
    const auto lied = folder.write("forged.vdb", lying);
    EXPECT_EQ(load_grid(lied, "").grid.active_voxels, 1u);
    EXPECT_EQ(inspect_vdb(lied).grids.at(0).index_max, glm::ivec3(0));

    // The root's counts, behind the background: tiles, then children.
    const std::string root = before_tree(bytes);
    for (const std::size_t skip : {8u, 12u})
        EXPECT_THAT(load_error(folder.write("forged.vdb", forge(bytes, root, skip, 0x7fffffff))),
                    HasSubstr("damaged"))
            << "root count at " << skip;
    EXPECT_THAT(load_error(folder.write("forged.vdb", forge(bytes, root, 16, 1))),
                HasSubstr("no multiple of 4096"));

    // Behind the first child's origin stand its masks of children and of values, 4096 bytes each.
    EXPECT_THAT(load_error(folder.write("forged.vdb", forge(bytes, root, 28 + 4096, char(1)))),
                HasSubstr("a child and a value in one place"));

    // A grid in the middle of itself, and one without end. Offsets follow the descriptor's names.
    const std::string descriptor = std::string("Tree_float_5_4_3\0\0\0\0", 20);
    for (const std::int64_t lie : {std::int64_t(-1), std::int64_t(0), std::int64_t(1) << 50})
        for (const std::size_t which : {0u, 16u})
            EXPECT_THAT(
                load_error(folder.write("forged.vdb", forge(bytes, descriptor, which, lie))),
                HasSubstr("damaged"))
                << "offset " << which << ": " << lie;
}

TEST(VdbFile, TwoTilesInOnePlaceAreRefused)
{
    const TempFolder folder;
    const auto file = folder.path() / "tiles.vdb";
    VdbGrid made;
    made.boxes = {{glm::ivec3(0), glm::ivec3(4095), glm::dvec3(1)},
                  {{4096, 0, 0}, {8191, 4095, 4095}, glm::dvec3(1)}};
    write_vdb(file, {made});
    const std::string bytes = test::read_bytes(file);
    // A tile of the root: 12 bytes of origin, 4 of value, 1 of whether it is active.
    const std::string forged = forge(bytes, before_tree(bytes), 16 + 17, glm::ivec3(0));
    EXPECT_THAT(load_error(folder.write("tiles.vdb", forged)), HasSubstr("two nodes in one place"));
}

TEST(VdbFile, ForgedBloscHeadersAreRefused)
{
    const TempFolder folder;
    const auto file = folder.path() / "forged.vdb";
    VdbGrid made;
    made.boxes = {{{0, 0, 0}, {7, 7, 7}, glm::dvec3(1)}};
    made.voxels = {{{0, 0, 0}, glm::dvec3(2)}};
    write_vdb(file, {made}, VdbCompression::blosc);
    const std::string bytes = test::read_bytes(file);
    // Blosc's header: 4 bytes of versions and flags, then three sizes. Type size 4, 2048 bytes out.
    std::size_t header = bytes.size();
    for (std::size_t i = bytes.size() - 16; i-- > 0 && header == bytes.size();) {
        std::uint32_t out;
        std::memcpy(&out, bytes.data() + i + 4, 4);
        if (bytes[i] == 2 && bytes[i + 3] == 4 && out == 2048)
            header = i;
    }
    ASSERT_LT(header, bytes.size()) << "the leaf's chunk was not found";
    for (const std::size_t field : {4u, 12u})
        for (const std::uint32_t lie : {0u, 15u, 2049u, 1u << 20, 0x7fffffffu, ~0u}) {
            std::string forged = bytes;
            std::memcpy(forged.data() + header + field, &lie, 4);
            EXPECT_THAT(load_error(folder.write("forged.vdb", forged)), HasSubstr("damaged"))
                << "field " << field << " is " << lie;
        }
    for (const std::uint32_t lie : {0u, 1u, 0x7fffffffu, ~0u}) {  // block size: Blosc's to judge
        std::string forged = bytes;
        std::memcpy(forged.data() + header + 8, &lie, 4);
        survives(folder.write("forged.vdb", forged), "block size " + std::to_string(lie));
    }
}

TEST(VdbFile, SingularAndInfiniteTransformsAreRefused)
{
    const TempFolder folder;
    const auto file = folder.path() / "flat.vdb";
    VdbGrid made = one_voxel("density", 1, "fog volume");
    made.world_from_index = {1, 0.5, 0, 0, 0, 1, 0, 0, 0, 0.5, 1, 0, 0, 0, 0, 1};
    write_vdb(file, {made});
    const std::string bytes = test::read_bytes(file);
    ASSERT_NE(bytes.find("AffineMap"), std::string::npos);
    const std::array<double, 3> third_is_first = {1, 0.5, 0};
    EXPECT_THAT(load_error(folder.write("flat.vdb", forge(bytes, "AffineMap", 64, third_is_first))),
                HasSubstr("can't be inverted"));
    EXPECT_THAT(
        load_error(folder.write("flat.vdb", forge(bytes, "AffineMap", 96, kNan)), "density"),
        HasSubstr("not finite"));
    EXPECT_THAT(load_error(folder.write("flat.vdb", forge(bytes, "AffineMap", 24, 0.1)), "density"),
                HasSubstr("not affine"));
    // Small is not flat.
    VdbGrid tiny = one_voxel("density", 1, "fog volume");
    tiny.world_from_index = glm::dmat4(1e-4);
    tiny.world_from_index[3][3] = 1;
    write_vdb(file, {tiny});
    EXPECT_EQ(load_grid(file, "").grid.world_from_index, tiny.world_from_index);
}

// --- Files of other people, where they are at hand ----------------------------------------------

class ExternalFiles : public testing::Test {
protected:
    void SetUp() override
    {
        if (!std::filesystem::exists(folder_))
            GTEST_SKIP() << folder_ << " is not there";
    }
    const std::filesystem::path folder_ =
        std::filesystem::path(FUM_TEST_SHARED) / "vdb" / "external";
};

TEST_F(ExternalFiles, AgreeWithOpenVdb)
{
    struct Case {
        const char* file;
        const char* grid;
        std::uint64_t active_voxels;
    };
    for (const Case& c : {Case{"wdas_cloud_sixteenth.vdb", "", 415642},
                          {"smoke.vdb", "", 1049275},
                          {"bifrost_torus.vdb", "", 2450},
                          {"three_grids_same_name.vdb", "density[1]", 2222},
                          {"oiio_sphere.vdb", "", 9047},
                          {"usd_densityAndHeat.vdb", "heat", 5224},
                          {"usd_blender_smoke.vdb", "", 71983},
                          {"dragon_affine.vdb", "", 156161},
                          {"dragon.vdb", "", 19660},
                          {"singlecloud_density_distance.vdb", "", 180770},
                          {"nebula_rgb.vdb", "", 97592},
                          {"blender_mantaflow_fluid_data_0001.vdb", "", 129065},
                          {"double_dense_smoke.vdb", "", 524288}}) {
        const VoxelGrid grid = load_grid(folder_ / c.file, c.grid).grid;
        EXPECT_EQ(grid.active_voxels, c.active_voxels) << c.file;
        expect_well_formed(grid);
        std::mt19937 random(4);
        std::vector<glm::ivec3> indices(20000);
        for (glm::ivec3& index : indices)
            for (int axis = 0; axis < 3; ++axis)
                index[axis] =
                    grid.index_min[axis] - 1 +
                    int(random() % unsigned(grid.index_max[axis] - grid.index_min[axis] + 3));
        expect_same_as_openvdb(grid, folder_ / c.file, indices);
    }
}

TEST_F(ExternalFiles, AreSaidToBeWhatTheyAre)
{
    EXPECT_THAT(load_grid(folder_ / "unnamed_level_set.vdb", "").notes,
                ElementsAre(HasSubstr("level set")));
    EXPECT_EQ(load_grid(folder_ / "nebula_rgb.vdb", "color").grid.channels, 3);
    EXPECT_THAT(load_error(folder_ / "sphere_points.vdb", "points"), HasSubstr("ptdataidx32"));
    EXPECT_THAT(load_error(folder_ / "damaged_truncated.vdb"), HasSubstr("damaged or cut short"));
    EXPECT_TRUE(load_grid(folder_ / "damaged_bad-bbox-empty.vdb", "empty").grid.empty());
    EXPECT_TRUE(load_grid(folder_ / "damaged_bad-bbox-inverted.vdb", "inverted").grid.empty());
}

}  // namespace
}  // namespace fumarole
