// The .nvdb reader against the .vdb of the same and against NanoVDB's own reader, and files made to
// break it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "support/make_nvdb.h"
#include "support/temp_folder.h"
#include <fumarole/asset/vdb_file.h>
#include <fumarole/errors.h>

namespace fumarole {
namespace {

using asset::inspect_vdb;
using asset::load_grid;
using asset::read_vdb_headers;
using asset::VdbInfo;
using test::convert_to_nvdb;
using test::NanoChecksum;
using test::NanoCodes;
using test::TempFolder;
using test::VdbCompression;
using test::VdbGrid;
using testing::HasSubstr;

constexpr std::size_t kHeader = 16, kMeta = 176;

/// Voxels of negative and positive indices, tiles of each size, inactive values of their own.
VdbGrid varied(VdbGrid::Type type, const std::string& name = "density")
{
    VdbGrid grid;
    grid.name = name;
    grid.type = type;
    grid.world_from_index = glm::dmat4(0.1);
    grid.world_from_index[1] = {0.02, 0.3, 0, 0};
    grid.world_from_index[3] = {1, -2, 3, 1};
    grid.boxes = {{{-24, 0, 8}, {-9, 15, 23}, {0.5, 0.25, 2}},
                  {{128, 0, 0}, {255, 127, 127}, glm::dvec3(0.75)},
                  {{-4096, -4096, -4096}, {-1, -1, -1}, glm::dvec3(0.125)}};
    std::mt19937 random(1);
    for (int i = 0; i < 300; ++i) {
        const auto coordinate = [&] { return int(random() % 40); };
        const auto number = [&] { return double(random() % 997) / 256; };
        const glm::ivec3 index(coordinate(), coordinate(), coordinate());
        const glm::dvec3 value(number(), number(), number());
        grid.voxels.push_back({index, value, i % 5 != 0});
    }
    return grid;
}

std::string error_of(const std::filesystem::path& file, const std::string& name = "")
{
    try {
        load_grid(file, name);
    } catch (const Error& e) {
        return e.what();
    }
    ADD_FAILURE() << "no Error was thrown";
    return "";
}

void expect_same(const VoxelGrid& a, const VoxelGrid& b)
{
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.channels, b.channels);
    EXPECT_EQ(a.world_from_index, b.world_from_index);
    EXPECT_EQ(a.bricks, b.bricks);
    EXPECT_EQ(a.values, b.values);
    ASSERT_EQ(a.tiles.size(), b.tiles.size());
    for (std::size_t i = 0; i < a.tiles.size(); ++i) {
        EXPECT_EQ(a.tiles[i].brick_min, b.tiles[i].brick_min);
        EXPECT_EQ(a.tiles[i].brick_max, b.tiles[i].brick_max);
        EXPECT_EQ(a.tiles[i].value, b.tiles[i].value);
    }
    EXPECT_EQ(a.index_min, b.index_min);
    EXPECT_EQ(a.index_max, b.index_max);
    EXPECT_EQ(a.active_voxels, b.active_voxels);
    EXPECT_EQ(a.max_value, b.max_value);
}

TEST(NanoVdb, EveryTypeAndCodecIsTheVdbOfTheSame)
{
    const TempFolder folder;
    const auto vdb = folder.path() / "of.vdb", nvdb = folder.path() / "of.nvdb";
    VdbGrid sphere;
    sphere.name = "surface";
    sphere.grid_class = "level set";
    sphere.sphere_radius = 6;
    VdbGrid empty;
    empty.name = "empty";
    test::write_vdb(vdb, {varied(VdbGrid::Type::float32), varied(VdbGrid::Type::float64, "double"),
                          varied(VdbGrid::Type::vec3s, "v"), sphere, empty,
                          varied(VdbGrid::Type::int32, "ids")});
    for (const auto& [compression, checksum] : {std::pair{VdbCompression::none, NanoChecksum::none},
                                                {VdbCompression::zip, NanoChecksum::head},
                                                {VdbCompression::blosc, NanoChecksum::all}}) {
        SCOPED_TRACE(int(compression));
        convert_to_nvdb(vdb, nvdb, NanoCodes::plain, compression, checksum);
        for (const char* name : {"density", "double", "v", "surface", "empty"}) {
            SCOPED_TRACE(name);
            expect_same(load_grid(nvdb, name).grid, load_grid(vdb, name).grid);
        }
        EXPECT_THAT(error_of(nvdb, "ids"), HasSubstr("of type int32; float, double and vec3"));
        EXPECT_EQ(load_grid(nvdb, "").grid.name, "density");

        const VdbInfo of_vdb = inspect_vdb(vdb), of_nvdb = inspect_vdb(nvdb);
        const VdbInfo headers = read_vdb_headers(nvdb);
        EXPECT_THAT(of_nvdb.creator, HasSubstr("NanoVDB 32."));
        ASSERT_EQ(of_nvdb.grids.size(), of_vdb.grids.size());
        for (std::size_t i = 0; i < of_nvdb.grids.size(); ++i) {  // in another order
            const asset::GridInfo& a = of_nvdb.grids[i];
            const asset::GridInfo& b =
                *std::ranges::find(of_vdb.grids, a.name, &asset::GridInfo::name);
            SCOPED_TRACE(b.name);
            EXPECT_EQ(a.name, b.name);
            EXPECT_EQ(a.value_type, b.value_type);
            EXPECT_EQ(a.grid_class, b.grid_class);
            EXPECT_EQ(a.active_voxels, b.active_voxels);
            EXPECT_EQ(a.active_tiles, b.active_tiles);
            EXPECT_EQ(a.leaf_bricks, b.refusal.empty() ? b.leaf_bricks : 0);
            EXPECT_EQ(a.index_min, b.index_min);
            EXPECT_EQ(a.index_max, b.index_max);
            EXPECT_EQ(a.world_min, b.world_min);
            EXPECT_EQ(a.min, b.min);
            EXPECT_EQ(a.max, b.max);
            EXPECT_EQ(a.mean, b.mean);
            EXPECT_EQ(a.refusal, b.refusal);
            EXPECT_EQ(headers.grids[i].active_voxels, b.active_voxels);
            EXPECT_EQ(headers.grids[i].world_from_index, b.world_from_index);
        }
    }
}

TEST(NanoVdb, CodesAreWhatNanoVdbReads)
{
    const TempFolder folder;
    const auto vdb = folder.path() / "of.vdb", nvdb = folder.path() / "of.nvdb";
    test::write_vdb(vdb, {varied(VdbGrid::Type::float32)});
    std::vector<glm::ivec3> indices;
    for (int x = -26; x < 42; ++x)
        for (int y = -2; y < 42; ++y)
            for (int z = -2; z < 42; ++z)
                indices.emplace_back(x, y, z);
    const VoxelGrid whole = load_grid(vdb, "").grid;
    for (const auto& [codes, type] : {std::pair{NanoCodes::fp4, "Fp4"},
                                      {NanoCodes::fp8, "Fp8"},
                                      {NanoCodes::fp16, "Fp16"},
                                      {NanoCodes::fpn, "FpN"}}) {
        SCOPED_TRACE(type);
        convert_to_nvdb(vdb, nvdb, codes, VdbCompression::none, NanoChecksum::all);
        const std::vector<double> expected = test::nanovdb_values(nvdb, codes, indices);
        const VoxelGrid grid = load_grid(nvdb, "").grid;
        const VoxelLookup lookup(grid), exact(whole);
        double worst = 0;
        for (std::size_t i = 0; i < indices.size(); ++i) {
            ASSERT_EQ(double(lookup.value(indices[i]).x), std::max(0.0, expected[i]));
            worst = std::max(worst, std::abs(double(exact.value(indices[i]).x) - expected[i]));
        }
        EXPECT_GT(worst, 0) << "nothing was rounded";
        EXPECT_LE(worst, codes == NanoCodes::fp4 ? 3.9 / 15 : 0.0155) << "of values up to 3.9";
        EXPECT_EQ(inspect_vdb(nvdb).grids[0].value_type, type);
    }
}

TEST(NanoVdb, SegmentsFollowEachOtherAndNamesRepeat)
{
    const TempFolder folder;
    const auto vdb = folder.path() / "of.vdb", nvdb = folder.path() / "of.nvdb";
    VdbGrid grid;
    grid.voxels = {{{1, 2, 3}, glm::dvec3(1)}};
    test::write_vdb(vdb, {grid});
    convert_to_nvdb(vdb, nvdb, NanoCodes::plain, VdbCompression::blosc);
    std::string bytes = test::read_bytes(nvdb);
    grid.voxels[0].value = glm::dvec3(2);
    test::write_vdb(vdb, {grid});
    convert_to_nvdb(vdb, nvdb, NanoCodes::plain, VdbCompression::zip);
    const auto both = folder.write("both.nvdb", bytes + test::read_bytes(nvdb));
    EXPECT_EQ(load_grid(both, "density[0]").grid.max_value, 1);
    EXPECT_EQ(load_grid(both, "density[1]").grid.max_value, 2);
}

// --- Damage -------------------------------------------------------------------------------------

/// A file of two grids, of about 0.6 MB: an upper node alone takes half of that.
std::string damageable(const TempFolder& folder, VdbCompression compression, NanoChecksum checksum,
                       NanoCodes codes = NanoCodes::plain)
{
    VdbGrid grid;
    grid.voxels = {{{1, 2, 3}, glm::dvec3(1)}, {{9, 0, 0}, glm::dvec3(2.5)}};
    VdbGrid vector;
    vector.name = "v";
    vector.type = VdbGrid::Type::vec3s;
    vector.voxels = {{{0, 0, 0}, glm::dvec3(1, 2, 3)}};
    const auto vdb = folder.path() / "of.vdb", nvdb = folder.path() / "of.nvdb";
    test::write_vdb(vdb, {grid, vector});
    convert_to_nvdb(vdb, nvdb, codes, compression, checksum);
    return test::read_bytes(nvdb);
}

/// Whether all of it was read; an Error must name the file, and everything else is a failure.
bool survives(const std::filesystem::path& file)
{
    bool read = true;
    for (const auto& action : std::vector<std::function<void()>>{[&] { load_grid(file, ""); },
                                                                 [&] { inspect_vdb(file); },
                                                                 [&] { read_vdb_headers(file); }}) {
        try {
            action();
        } catch (const Error& e) {
            EXPECT_THAT(e.what(), HasSubstr(file.filename().string()));
            read = false;
        }
    }
    std::filesystem::remove(file);
    return read;
}

TEST(NanoVdb, AFileCutAnywhereIsAnError)
{
    const TempFolder folder;
    for (const VdbCompression compression :
         {VdbCompression::none, VdbCompression::zip, VdbCompression::blosc}) {
        const std::string bytes = damageable(folder, compression, NanoChecksum::none);
        const std::size_t step = std::max<std::size_t>(97, bytes.size() / 60);
        for (std::size_t size = 1; size < bytes.size(); size += size < 250 ? 7 : step)
            EXPECT_FALSE(survives(folder.write("cut.nvdb", bytes.substr(0, size))))
                << size << " of " << bytes.size();
    }
}

// 216 files a time. By hand, thousands of other ones under ASan: --gtest_shuffle --gtest_repeat=50.
TEST(NanoVdb, FlippedBytesNeverDoWorseThanAnError)
{
    const TempFolder folder;
    std::mt19937 random(unsigned(testing::UnitTest::GetInstance()->random_seed()));
    int refused = 0;
    for (const VdbCompression compression :
         {VdbCompression::none, VdbCompression::zip, VdbCompression::blosc})
        for (const NanoCodes codes : {NanoCodes::plain, NanoCodes::fpn}) {
            // Without its checksum, or all but the tree's walk would be of no use.
            const std::string bytes = damageable(folder, compression, NanoChecksum::none, codes);
            // What a flip is likely to matter in: metadata, grid, tree and root; then offsets of
            // children, which are most of what is not 0; then anything.
            std::vector<std::size_t> telling;
            for (std::size_t i = 0; i < bytes.size(); ++i)
                if (i < 1400 || bytes[i] != 0)
                    telling.push_back(i);
            for (int i = 0; i < 36; ++i) {
                std::string mutant = bytes;
                for (auto flips = 1 + random() % 3; flips > 0; --flips) {
                    const std::size_t at = random() % 8 == 0 ? random() % bytes.size()
                                                             : telling[random() % telling.size()];
                    mutant[at] =
                        char(random() % 2 == 0 ? random() : mutant[at] ^ 1 << random() % 8);
                }
                refused += survives(folder.write("mutant.nvdb", mutant)) ? 0 : 1;
            }
        }
    EXPECT_GT(refused, 40) << "of 216";
}

template <class T> void put(std::string& bytes, std::size_t at, T value)
{
    std::memcpy(bytes.data() + at, &value, sizeof(value));
}

TEST(NanoVdb, WhatIsForgedIsNamed)
{
    const TempFolder folder;
    const std::string good = damageable(folder, VdbCompression::none, NanoChecksum::none);
    // Grids begin behind the header and both grids' metadata with names and their zeros.
    const std::size_t grid = kHeader + 2 * kMeta + sizeof("density") + sizeof("v");
    const std::size_t tree = grid + 672, root = tree + 64;
    const auto error = [&](const auto& forge) {
        std::string bytes = good;
        forge(bytes);
        return error_of(folder.write("forged.nvdb", bytes));
    };
    const auto with = [&](std::size_t at, auto value) {
        return error([&](std::string& bytes) { put(bytes, at, value); });
    };
    EXPECT_THAT(with(8, std::uint32_t(31u << 21)), HasSubstr("NanoVDB 31.0.0, and 32 is read"));
    EXPECT_THAT(with(14, std::uint16_t(7)), HasSubstr("packed in an unknown way (7)"));
    EXPECT_THAT(with(kHeader, std::uint64_t(1) << 60), HasSubstr("is said to have"));
    EXPECT_THAT(with(kHeader + 8, std::uint64_t(1) << 60), HasSubstr("runs past the end"));
    EXPECT_THAT(with(kHeader + 32, std::uint32_t(2)), HasSubstr("of type double, and float"));
    EXPECT_THAT(with(kHeader + 136, std::uint32_t(-1)), HasSubstr("name runs past the end"));
    EXPECT_THAT(with(grid, 'n'), HasSubstr("does not begin as one"));
    EXPECT_THAT(with(grid + 384, std::numeric_limits<double>::quiet_NaN()),
                HasSubstr("not finite"));
    EXPECT_THAT(with(tree + 24, std::uint64_t(-64)), HasSubstr("its root is said to be at"));
    EXPECT_THAT(with(tree + 32, std::uint32_t(1) << 31), HasSubstr("nodes of level 0"));
    EXPECT_THAT(with(tree + 32, std::uint32_t(1)), HasSubstr("more nodes of level 0 than the 1"));
    EXPECT_THAT(with(tree + 32, std::uint32_t(3)), HasSubstr("2 nodes of level 0 where 3"));
    EXPECT_THAT(with(root + 24, std::uint32_t(-1)), HasSubstr("a root of 4294967295 tiles"));
    const std::size_t tile = root + 64;
    EXPECT_THAT(with(tile, std::uint64_t(1) << 63), HasSubstr("has the key"));
    for (const std::int64_t child : {std::int64_t(32), std::int64_t(1) << 62, std::int64_t(-4096),
                                     std::numeric_limits<std::int64_t>::min()})
        EXPECT_THAT(with(tile + 8, child), HasSubstr("a node of level 2 is said to be"));

    // Two parents of one leaf: a small file could ask for all of memory.
    const std::size_t upper = tile + 32, lower = upper + 32 + 2 * 4096 + 32 + 32768 * 8;
    const std::size_t lower_table = lower + 32 + 2 * 512 + 32;
    const auto twice = error([&](std::string& bytes) {
        std::memcpy(bytes.data() + lower_table + 256 * 8, bytes.data() + lower_table, 8);
    });
    EXPECT_THAT(twice, HasSubstr("a leaf of (1, 2, 3) where that of (8, 0, 0) belongs"));

    // Of a packed one it says how much comes out, which may be so much that sums wrap round.
    for (const VdbCompression compression : {VdbCompression::zip, VdbCompression::blosc})
        for (const std::uint64_t size : {std::uint64_t(1) << 60, ~std::uint64_t(0)}) {
            std::string bytes = damageable(folder, compression, NanoChecksum::none);
            put(bytes, kHeader, size);
            EXPECT_THAT(error_of(folder.write("forged.nvdb", bytes)),
                        HasSubstr("forged.nvdb: too large"));
        }

    // With its checksums, a changed value is noticed too.
    for (const auto& [checksum, at, part] :
         {std::tuple{NanoChecksum::head, root + 28, "head"},
          {NanoChecksum::all, root + 28, "head"},
          {NanoChecksum::all, lower_table + 4096 * 8 + 200, "values"}}) {
        std::string bytes = damageable(folder, VdbCompression::none, checksum);
        bytes[at] ^= 1;
        EXPECT_THAT(error_of(folder.write("forged.nvdb", bytes)),
                    HasSubstr(std::string("not that of its ") + part));
    }
}

/// A file of another maker, of version 32.5, four grids in one buffer, where it is at hand.
TEST(NanoVdb, AFileOfAnotherMakerIsRead)
{
    const auto file = std::filesystem::path(FUM_TEST_SHARED) / "vdb" / "external" / "batch.nvdb";
    if (!std::filesystem::exists(file))
        GTEST_SKIP() << file << " is not there";
    const VdbInfo info = inspect_vdb(file);
    ASSERT_EQ(info.grids.size(), 4u);
    EXPECT_EQ(info.grids[0].active_voxels, 774u);
    EXPECT_EQ(info.grids[0].grid_class, "level set");
    EXPECT_EQ(info.grids[0].index_min, glm::ivec3(-6, -10, -6));
    EXPECT_EQ(info.grids[0].leaf_bricks, 14u);
    EXPECT_EQ(info.grids[3].name, "z[3]");
    EXPECT_GT(info.grids[3].active_voxels, 0u);
}

}  // namespace
}  // namespace fumarole
