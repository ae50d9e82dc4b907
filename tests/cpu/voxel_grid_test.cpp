// VoxelLookup against grids small enough to know every value of.

#include <fumarole/errors.h>
#include <fumarole/voxel_grid.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace fumarole {
namespace {

/// Different for every voxel, > 0, and exact in float.
float value_at(glm::ivec3 index, int channel = 0)
{
    return float(1 + (index.x & 63) + 64 * (index.y & 63) + 4096 * (index.z & 63)) +
           0.25f * float(channel);
}

void add_brick(VoxelGrid& grid, glm::ivec3 brick)
{
    grid.bricks.push_back(brick);
    for (int z = 0; z < 8; ++z)
        for (int y = 0; y < 8; ++y)
            for (int x = 0; x < 8; ++x)
                for (int c = 0; c < grid.channels; ++c)
                    grid.values.push_back(value_at(brick * 8 + glm::ivec3(x, y, z), c));
    const glm::ivec3 lo = brick * 8, hi = lo + 7;
    grid.index_min = grid.bricks.size() == 1 ? lo : glm::min(grid.index_min, lo);
    grid.index_max = grid.bricks.size() == 1 ? hi : glm::max(grid.index_max, hi);
}

/// Two neighbours across 0 along x, and a tile of 2 x 1 x 1 bricks beside them along y.
VoxelGrid small_grid(int channels = 1)
{
    VoxelGrid grid;
    grid.channels = channels;
    add_brick(grid, {-1, 0, 0});
    add_brick(grid, {0, 0, 0});
    grid.tiles.push_back({{-1, 1, 0}, {0, 1, 0}, {5, 6, 7}});
    grid.index_max.y = 15;
    return grid;
}

/// small_grid, and one brick so far away that no table of bricks can hold both.
VoxelGrid sparse_grid(int channels = 1)
{
    VoxelGrid grid = small_grid(channels);
    add_brick(grid, {1 << 26, 1 << 26, 1 << 26});
    return grid;
}

void expect_vec(glm::dvec3 actual, glm::dvec3 expected, const char* where)
{
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(actual[c], expected[c], 1e-9 * (1 + std::abs(expected[c])))
            << where << ", channel " << c;
}

class Lookup : public testing::TestWithParam<bool> {
protected:
    static VoxelGrid make(int channels = 1)
    {
        return GetParam() ? sparse_grid(channels) : small_grid(channels);
    }
};

TEST_P(Lookup, FindsEveryVoxelOfBricksAndTiles)
{
    const VoxelGrid grid = make();
    const VoxelLookup lookup(grid);
    for (int z = -2; z < 10; ++z)
        for (int y = -2; y < 18; ++y)
            for (int x = -10; x < 10; ++x) {
                float expected = 0;
                if (z >= 0 && z < 8 && x >= -8 && x < 8 && y >= 0 && y < 16)
                    expected = y < 8 ? value_at({x, y, z}) : 5.0f;
                ASSERT_EQ(lookup.value({x, y, z}), glm::vec3(expected, 0, 0))
                    << "voxel " << x << " " << y << " " << z;
            }
}

TEST_P(Lookup, KeepsTheChannelsOfAVoxelTogether)
{
    const VoxelGrid grid = make(3);
    const VoxelLookup lookup(grid);
    const glm::ivec3 index(-3, 2, 5);
    EXPECT_EQ(lookup.value(index),
              glm::vec3(value_at(index, 0), value_at(index, 1), value_at(index, 2)));
    EXPECT_EQ(lookup.value({3, 9, 1}), glm::vec3(5, 6, 7)) << "in a tile";
}

TEST_P(Lookup, SamplesAVoxelsCentreAsItsValue)
{
    const VoxelGrid grid = make();
    const VoxelLookup lookup(grid);
    for (const glm::ivec3 index : {glm::ivec3(-8, 0, 0), {-1, 7, 7}, {0, 0, 0}, {7, 7, 7}})
        expect_vec(lookup.sample(index), {value_at(index), 0, 0}, "at a centre");
    expect_vec(lookup.sample({2, 10, 3}), {5, 0, 0}, "in a tile");
}

TEST_P(Lookup, SamplesLinearlyInsideAndAcrossBricks)
{
    // value_at is linear where no coordinate wraps, so trilinear sampling is exact there.
    const VoxelGrid grid = make(3);
    const VoxelLookup lookup(grid);
    const glm::dvec3 p(3.25, 4.5, 6.75);
    const double inside = 1 + p.x + 64 * p.y + 4096 * p.z;
    expect_vec(lookup.sample(p), {inside, inside + 0.25, inside + 0.5}, "inside a brick");

    const double f = 0.3;  // between the bricks: x = -1 and x = 0
    const double across = (1 - f) * value_at({-1, 2, 2}) + f * value_at({0, 2, 2});
    expect_vec(lookup.sample({-1 + f, 2, 2}), {across, across + 0.25, across + 0.5},
               "across a face of bricks");

    const double into_tile = (1 - f) * value_at({2, 7, 2}) + f * 5;
    EXPECT_NEAR(lookup.sample({2, 7 + f, 2}).x, into_tile, 1e-9) << "from a brick into a tile";
}

TEST_P(Lookup, FadesToZeroOneVoxelPastTheOutermost)
{
    const VoxelGrid grid = make();
    const VoxelLookup lookup(grid);
    const double outermost = value_at({3, 3, 7});
    EXPECT_NEAR(lookup.sample({3, 3, 7.25}).x, 0.75 * outermost, 1e-9);
    EXPECT_EQ(lookup.sample({3, 3, 8.0}).x, 0);
    EXPECT_NEAR(lookup.sample({3, -0.75, 3}).x, 0.25 * value_at({3, 0, 3}), 1e-9);
    EXPECT_EQ(lookup.sample({3, -1.0, 3}).x, 0);
    EXPECT_NEAR(lookup.sample({3, 15.5, 3}).x, 2.5, 1e-9) << "past a tile";
}

TEST_P(Lookup, IsZeroForPointsThatNoIntegerHolds)
{
    const VoxelGrid grid = make();
    const VoxelLookup lookup(grid);
    const double inf = std::numeric_limits<double>::infinity();
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const double x : {inf, -inf, nan, 1e300, -1e300, 2147483648.0, -2147483649.0})
        for (int axis = 0; axis < 3; ++axis) {
            glm::dvec3 p(1);
            p[axis] = x;
            EXPECT_EQ(lookup.sample(p), glm::dvec3(0)) << "axis " << axis << " at " << x;
        }
}

INSTANTIATE_TEST_SUITE_P(Bricks, Lookup, testing::Bool(), [](const auto& test) {
    return std::string(test.param ? "Hashed" : "InATable");
});

TEST(VoxelLookup, FindsABrickFarAway)
{
    const VoxelGrid grid = sparse_grid();
    const VoxelLookup lookup(grid);
    const glm::ivec3 far = glm::ivec3(1 << 29);
    EXPECT_EQ(lookup.value(far).x, value_at(far));
    EXPECT_EQ(lookup.value(far / 2), glm::vec3(0)) << "half way there is nothing";
    EXPECT_NEAR(lookup.sample(glm::dvec3(far) + 0.5).x,
                (double(value_at(far)) + double(value_at(far + 1))) / 2, 1e-6);
}

TEST(VoxelLookup, OfAnEmptyGridIsZeroEverywhere)
{
    const VoxelGrid grid;
    const VoxelLookup lookup(grid);
    EXPECT_TRUE(grid.empty());
    EXPECT_EQ(lookup.value({0, 0, 0}), glm::vec3(0));
    EXPECT_EQ(lookup.sample({0, 0, 0}), glm::dvec3(0));
}

TEST(VoxelLookup, OfOneHugeTileNeedsNoTable)
{
    VoxelGrid grid;  // 4096^3 voxels: 512^3 bricks
    grid.tiles.push_back({{0, 0, 0}, {511, 511, 511}, {2, 0, 0}});
    grid.index_min = {0, 0, 0};
    grid.index_max = {4095, 4095, 4095};
    const VoxelLookup lookup(grid);
    EXPECT_EQ(lookup.value({4095, 0, 17}).x, 2.0f);
    EXPECT_EQ(lookup.value({4096, 0, 17}).x, 0.0f);
    EXPECT_EQ(lookup.sample({4095.5, 10, 10}).x, 1.0);
}

TEST(VoxelGrid, IsMadeOfDensitiesInMemory)
{
    // Two bricks along x of which the second is cut; what is no density counts as none.
    const glm::ivec3 size(11, 3, 9);
    std::vector<float> density;
    for (int z = 0; z < size.z; ++z)
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x)
                density.push_back(z < 8 ? value_at({x, y, z}) : 0.0f);
    density[0] = -1;
    density[1] = std::numeric_limits<float>::infinity();
    density[2] = std::numeric_limits<float>::quiet_NaN();
    const VoxelGrid grid = make_voxel_grid(density, size, glm::dmat4(1.0));
    EXPECT_EQ(grid.bricks, (std::vector<glm::ivec3>{{0, 0, 0}, {1, 0, 0}}));
    EXPECT_EQ(grid.index_min, glm::ivec3(0));
    EXPECT_EQ(grid.index_max, glm::ivec3(10, 2, 7));
    EXPECT_EQ(grid.active_voxels, std::uint64_t{11 * 3 * 8 - 3});
    EXPECT_EQ(grid.max_value, value_at({10, 2, 7}));
    const VoxelLookup lookup(grid);
    for (int x = 0; x < 3; ++x)
        EXPECT_EQ(lookup.value({x, 0, 0}).x, 0.0f);
    EXPECT_EQ(lookup.value({3, 0, 0}).x, value_at({3, 0, 0}));
    EXPECT_EQ(lookup.value({10, 2, 7}).x, value_at({10, 2, 7}));
    EXPECT_EQ(lookup.value({11, 2, 7}).x, 0.0f);
    EXPECT_TRUE(make_voxel_grid(std::vector<float>(27), glm::ivec3(3), glm::dmat4(1.0)).empty());
    EXPECT_THROW(make_voxel_grid(density, {11, 3, 8}, glm::dmat4(1.0)), Error);
}

}  // namespace
}  // namespace fumarole
