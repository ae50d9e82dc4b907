// grid_layout: what the GPU samples is the grid. The hardware's part, linear filtering between
// texels, is emulated here in double precision and held against VoxelLookup::sample.

#include "medium/grid_layout.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <functional>
#include <random>
#include <string>

#include "medium/occupancy.h"
#include "shared/brick_page.h"
#include <fumarole/errors.h>
#include <fumarole/voxel_grid.h>

namespace fumarole::medium {

namespace {

using shared::kPageBrick;

constexpr std::size_t kBrickVoxels = VoxelGrid::kBrickVoxels;

bool before(const glm::ivec3& a, const glm::ivec3& b)
{
    return a.z != b.z ? a.z < b.z : a.y != b.y ? a.y < b.y : a.x < b.x;
}

/// Sets a grid's bounds and maximum from its bricks and tiles.
void finish(VoxelGrid& grid)
{
    glm::ivec3 lo{1}, hi{0};
    bool any = false;
    const auto include = [&](const glm::ivec3& a, const glm::ivec3& b, float value) {
        if (value <= 0)
            return;
        lo = any ? glm::min(lo, a) : a;
        hi = any ? glm::max(hi, b) : b;
        any = true;
        grid.max_value = std::max(grid.max_value, value);
    };
    const auto channels = static_cast<std::size_t>(grid.channels);
    for (std::size_t b = 0; b < grid.bricks.size(); ++b) {
        for (std::size_t v = 0; v < kBrickVoxels; ++v) {
            const auto i = static_cast<int>(v);
            const glm::ivec3 at = grid.bricks[b] * 8 + glm::ivec3{i % 8, i / 8 % 8, i / 64};
            for (std::size_t c = 0; c < channels; ++c)
                include(at, at, grid.values[(b * kBrickVoxels + v) * channels + c]);
        }
    }
    for (const VoxelTile& tile : grid.tiles)
        for (int c = 0; c < grid.channels; ++c)
            include(tile.brick_min * 8, tile.brick_max * 8 + 7, tile.value[c]);
    grid.index_min = lo;
    grid.index_max = hi;
}

/// A grid with the bricks asked for, sorted, with values from `value()`.
VoxelGrid grid_of(std::vector<glm::ivec3> bricks, int channels, const std::function<float()>& value)
{
    VoxelGrid grid;
    grid.name = "density";
    grid.channels = channels;
    std::sort(bricks.begin(), bricks.end(), before);
    grid.bricks = std::move(bricks);
    grid.values.resize(grid.bricks.size() * kBrickVoxels * static_cast<std::size_t>(channels));
    std::generate(grid.values.begin(), grid.values.end(), value);
    finish(grid);
    return grid;
}

/// Bricks scattered over both signs, some full, some with a few values, some all 0, some constant;
/// tiles that touch bricks and each other. `scale` is the largest value.
VoxelGrid random_grid(unsigned seed, int channels, float scale)
{
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> uniform(0, scale);
    std::uniform_int_distribution<int> percent(0, 99);

    VoxelGrid grid;
    grid.name = "density";
    grid.channels = channels;
    const float shared =
        uniform(random);  // of two tiles that touch: cells across them are constant
    grid.tiles = {{{-4, -1, 0}, {-3, 1, 1}, glm::vec3{shared}},
                  {{-2, -1, 0}, {-2, 1, 1}, glm::vec3{shared}},
                  {{1, -3, -2}, {1, -3, -2}, {uniform(random), uniform(random), uniform(random)}}};
    const auto in_tile = [&](const glm::ivec3& b) {
        return std::any_of(grid.tiles.begin(), grid.tiles.end(), [&](const VoxelTile& t) {
            return glm::all(glm::greaterThanEqual(b, t.brick_min)) &&
                   glm::all(glm::lessThanEqual(b, t.brick_max));
        });
    };
    for (int z = -3; z <= 3; ++z)
        for (int y = -3; y <= 3; ++y)
            for (int x = -5; x <= 3; ++x)
                if (percent(random) < 30 && !in_tile({x, y, z}))
                    grid.bricks.push_back({x, y, z});
    for (std::size_t b = 0; b < grid.bricks.size(); ++b) {
        const int kind = percent(random);
        const float constant = kind < 20 ? shared : uniform(random);
        for (std::size_t v = 0; v < kBrickVoxels * static_cast<std::size_t>(channels); ++v)
            grid.values.push_back(kind < 15   ? 0.0f
                                  : kind < 30 ? constant
                                  : kind < 60 ? (percent(random) < 3 ? uniform(random) : 0.0f)
                                              : uniform(random));
    }
    finish(grid);
    return grid;
}

/// Decoded by shifts, so not by the code that encoded it.
double half_value(std::uint16_t half)
{
    const int exponent = half >> 10 & 31;
    const double mantissa = (half & 1023) / 1024.0;
    return exponent == 0 ? std::ldexp(mantissa, -14) : std::ldexp(1 + mantissa, exponent - 15);
}

/// What texelFetch gives.
glm::dvec3 texel(const GridLayout& g, glm::ivec3 at)
{
    at = glm::clamp(at, glm::ivec3{0}, g.texture_size - 1);
    const std::size_t bytes = g.storage == Storage::r32f ? 4 : g.storage == Storage::r16f ? 2 : 1;
    const auto sx = static_cast<std::size_t>(g.texture_size.x);
    const auto sy = static_cast<std::size_t>(g.texture_size.y);
    const std::size_t i =
        (static_cast<std::size_t>(at.z) * sy + static_cast<std::size_t>(at.y)) * sx +
        static_cast<std::size_t>(at.x);
    glm::dvec3 value{0};
    for (int c = 0; c < std::min(g.channels, 3); ++c) {
        const std::uint8_t* from =
            g.texels.data() +
            (i * static_cast<std::size_t>(g.channels) + static_cast<std::size_t>(c)) * bytes;
        if (g.storage == Storage::r32f) {
            float v;
            std::memcpy(&v, from, sizeof v);
            value[c] = v;
        } else if (g.storage == Storage::r16f) {
            std::uint16_t v;
            std::memcpy(&v, from, sizeof v);
            value[c] = half_value(v);
        } else {
            value[c] = *from / 255.0;
        }
    }
    return value;
}

/// What `texture` gives at a coordinate in texels, filtered linearly.
glm::dvec3 filtered(const GridLayout& g, const glm::dvec3& texel_coordinate)
{
    const glm::dvec3 base = glm::floor(texel_coordinate - 0.5);
    const glm::dvec3 t = texel_coordinate - 0.5 - base;
    glm::dvec3 sum{0};
    for (int corner = 0; corner < 8; ++corner) {
        const glm::ivec3 d{corner & 1, corner >> 1 & 1, corner >> 2};
        const glm::dvec3 w = glm::mix(1.0 - t, t, glm::dvec3(d));
        if (const double weight = w.x * w.y * w.z; weight > 0)
            sum += weight * texel(g, glm::ivec3(base) + d);
    }
    return sum;
}

std::uint32_t page_at(const GridLayout& g, const glm::ivec3& page)
{
    if (glm::any(glm::lessThan(page, glm::ivec3{0})) ||
        glm::any(glm::greaterThanEqual(page, g.page_count)))
        return 0;
    return g.pages.at(
        static_cast<std::size_t>((page.z * g.page_count.y + page.y) * g.page_count.x + page.x));
}

/// The same of a tree of pages.
std::uint32_t leaf_at(const GridLayout& g, const glm::ivec3& page)
{
    int shift = 3 * g.tree.levels;
    if (glm::any(glm::lessThan(page, glm::ivec3{0})) ||
        glm::any(glm::greaterThanEqual(page, glm::ivec3{1 << shift})))
        return 0;
    std::uint32_t entry = kPageBrick;
    do {
        shift -= 3;
        const glm::ivec3 node{entry & 255u, entry >> 8 & 255u, entry >> 16 & 255u};
        entry = page_at(g, 8 * node + (page >> shift & 7));
    } while (entry >= kPageBrick && shift > 0);
    return entry;
}

double scale_of(std::uint32_t page)
{
    // Steps of an eighth of an octave, down from 1: 15/16, 14/16, ... 8/16, 15/32, ...
    const int step = page >> 24 & 127u;
    return step == 0 ? 1 : std::ldexp((15 - (step - 1) % 8) / 16.0, -(step - 1) / 8);
}

/// The shader's lookup.
glm::dvec3 sample(const GridLayout& g, const glm::dvec3& p_index)
{
    const glm::dvec3 q = p_index - glm::dvec3(g.origin);
    const double scale = g.value_scale;
    if (g.layout == Layout::dense)
        return scale * filtered(g, q + 0.5);
    const glm::ivec3 page = glm::floor(q / 8.0);
    const std::uint32_t entry = g.tree.levels > 0 ? leaf_at(g, page) : page_at(g, page);
    if (entry < kPageBrick)
        return {scale * static_cast<double>(std::bit_cast<float>(entry << 1)), 0, 0};
    const glm::ivec3 slot{entry & 255u, entry >> 8 & 255u, entry >> 16 & 255u};
    return scale * scale_of(entry) *
           filtered(g, glm::dvec3(slot * 9) + (q - 8.0 * glm::dvec3(page)) + 0.5);
}

/// Of a page's 9^3 values.
double largest_in(const VoxelLookup& lookup, const glm::ivec3& first)
{
    float most = 0;
    for (int i = 0; i < 729; ++i) {
        const glm::vec3 v = lookup.value(first + glm::ivec3{i % 9, i / 9 % 9, i / 81});
        most = std::max({most, v.x, v.y, v.z});
    }
    return double{most};
}

/// What the storage's absolute error is relative to: for bricks of bytes their own largest value,
/// rounded up by an eighth, as far down as scales go; else the grid's.
double scale_at(const GridLayout& g, const VoxelLookup& lookup, const VoxelGrid& grid,
                const glm::dvec3& p_index)
{
    const double all{grid.max_value};
    if (g.storage != Storage::r8 || g.layout == Layout::dense)
        return all;
    const glm::ivec3 page = glm::floor((p_index - glm::dvec3(g.origin)) / 8.0);
    return std::clamp(1.125 * largest_in(lookup, g.origin + 8 * page), 0x1.2p-16 * all, all);
}

double bound_at(const GridLayout& g, const glm::dvec3& p_index)
{
    const glm::ivec3 page = glm::floor((p_index - glm::dvec3(g.maxima_origin)) / 8.0);
    if (glm::any(glm::lessThan(page, glm::ivec3{0})) ||
        glm::any(glm::greaterThanEqual(page, g.maxima_count)))
        return 0;
    const auto i =
        static_cast<std::size_t>((page.z * g.maxima_count.y + page.y) * g.maxima_count.x + page.x);
    // Between texels the emulation's rounding passes a border by 2^-40 or so.
    const glm::dvec3 q = p_index - glm::dvec3(g.maxima_origin + 8 * page);
    const glm::dvec3 min(g.extents.at(i).min), max(g.extents.at(i).max);
    if (glm::any(glm::lessThan(q, min - 1e-6)) || glm::any(glm::greaterThan(q, max + 1e-6)))
        return 0;
    return static_cast<double>(g.maxima.at(i));
}

/// Points everywhere, and where things go wrong: on voxel centres, on and beside brick borders, in
/// the rim between the outermost voxels and 0, outside.
std::vector<glm::dvec3> probe_points(const VoxelGrid& grid, int count)
{
    std::mt19937 random(99);
    std::uniform_real_distribution<double> unit(0, 1);
    std::uniform_int_distribution<int> kind(0, 5);
    const glm::dvec3 lo = glm::dvec3(grid.index_min) - 3.0, hi = glm::dvec3(grid.index_max) + 3.0;
    std::vector<glm::dvec3> points;
    for (int i = 0; i < count; ++i) {
        glm::dvec3 p;
        for (int axis = 0; axis < 3; ++axis) {
            const double x = lo[axis] + unit(random) * (hi[axis] - lo[axis]);
            switch (kind(random)) {
            case 0:
                p[axis] = std::round(x);
                break;
            case 1:
                p[axis] = 8 * std::round(x / 8);
                break;
            case 2:
                p[axis] = 8 * std::round(x / 8) + (unit(random) < 0.5 ? -1e-9 : 1e-9);
                break;
            case 3:
                p[axis] = (unit(random) < 0.5 ? grid.index_min[axis] - 1 : grid.index_max[axis]) +
                          unit(random);
                break;
            default:
                p[axis] = x;
            }
        }
        points.push_back(p);
    }
    return points;
}

struct StorageCase {
    const char* name;
    Storage storage;
    double relative;  // of the sample
    double absolute;  // of scale_at()
};

constexpr StorageCase kStorageCases[] = {
    // A texel is the value itself; a constant page keeps 22 of its 23 mantissa bits, rounded. The
    // emulation's texel coordinates, up to 200, carry 2^-46 of rounding into its weights.
    {"r32f", Storage::r32f, 0x1p-23, 0x1p-44},
    // 11 bits, rounded to nearest: half an ulp; below 2^-29 of the largest value half has a fixed
    // step of 2^-39 of it (its denormals), of which half is lost.
    {"r16f", Storage::r16f, 0x1p-11, 0x1p-39},
    // 255 steps, rounded to nearest, in single precision.
    {"r8", Storage::r8, 1e-6, 0.5 / 255 * (1 + 1e-6)},
};

struct FieldCase {
    Layout layout;
    StorageCase storage;
    int channels;
};

class GridField : public testing::TestWithParam<FieldCase> {};

std::vector<FieldCase> field_cases()
{
    std::vector<FieldCase> cases;
    for (const Layout layout : {Layout::dense, Layout::bricks})
        for (const StorageCase& storage : kStorageCases)
            for (const int channels : {1, 3})
                cases.push_back({layout, storage, channels});
    return cases;
}

TEST_P(GridField, SamplesAsTheGridDoes)
{
    const auto& [layout, storage, channels] = GetParam();
    for (unsigned seed = 1; seed <= 4; ++seed) {
        const VoxelGrid grid = random_grid(seed, channels, seed == 4 ? 3e4f : 1.7f);
        const VoxelLookup lookup(grid);
        const GridLayout g = make_layout(grid, layout, storage.storage, {});
        ASSERT_EQ(g.layout, layout);
        ASSERT_EQ(g.channels, channels == 3 ? 4 : 1);
        double worst = 0;
        for (const glm::dvec3& p : probe_points(grid, 20000)) {
            const glm::dvec3 want = lookup.sample(p), got = sample(g, p);
            const double absolute = storage.absolute * scale_at(g, lookup, grid, p);
            for (int c = 0; c < 3; ++c) {
                const double allowed = storage.relative * want[c] + absolute;
                const double error = std::abs(got[c] - want[c]);
                worst = std::max(worst, error / double{grid.max_value});
                ASSERT_LE(error, allowed)
                    << "channel " << c << " at " << p.x << ' ' << p.y << ' ' << p.z;
            }
        }
        RecordProperty("worst_error_of_max", std::to_string(worst));
        if (storage.storage == Storage::r8) {
            EXPECT_GT(worst, 0.3 / 255);  // else the points don't meet the values
        }
    }
}

TEST_P(GridField, MaximaBoundEverySample)
{
    const auto& [layout, storage, channels] = GetParam();
    const VoxelGrid grid = random_grid(5, channels, 0.83f);
    const GridLayout g = make_layout(grid, layout, storage.storage, {});
    ASSERT_EQ(g.maxima.size(), std::size_t(g.maxima_count.x * g.maxima_count.y * g.maxima_count.z));
    for (const glm::dvec3& p : probe_points(grid, 20000)) {
        const glm::dvec3 v = sample(g, p);
        ASSERT_LE(std::max({v.x, v.y, v.z}), bound_at(g, p)) << p.x << ' ' << p.y << ' ' << p.z;
    }
    // And are no looser than storage makes them: 2^-20 of margin, and the storage's own rounding.
    const float most = *std::max_element(g.maxima.begin(), g.maxima.end());
    EXPECT_LE(double{most}, double{grid.max_value} * (1 + 0x1p-19 + storage.relative));
}

TEST(GridLayout, ExtentsEndAVoxelAroundWhatIsHeld)
{
    VoxelGrid grid = random_grid(5, 1, 1);
    grid.tiles.clear();
    grid.bricks = {{0, 0, 0}};
    grid.values.assign(VoxelGrid::kBrickVoxels, 0);
    grid.values[(5 * 8 + 0) * 8 + 2] = 1;  // z 5, y 0, x 2
    grid.index_min = grid.index_max = {2, 0, 5};
    grid.max_value = 1;
    const GridLayout g = make_layout(grid, Layout::bricks, Storage::r32f, {});
    int held = 0;
    for (std::size_t i = 0; i < g.maxima.size(); ++i) {
        if (!(g.maxima[i] > 0))
            continue;
        ++held;
        const bool upper = g.extents[i].min.y == 0;  // the page of the voxel, else that below it
        EXPECT_EQ(glm::ivec3(g.extents[i].min), glm::ivec3(1, upper ? 0 : 7, 4));
        EXPECT_EQ(glm::ivec3(g.extents[i].max), glm::ivec3(3, upper ? 1 : 8, 6));
    }
    EXPECT_EQ(held, 2);
}

TEST_P(GridField, PlanIsWhatIsMade)
{
    const auto& [layout, storage, channels] = GetParam();
    const VoxelGrid grid = random_grid(6, channels, 1);
    const GridLayout plan = plan_layout(grid, layout, storage.storage, {});
    const GridLayout made = make_layout(grid, layout, storage.storage, {});
    EXPECT_EQ(plan.texture_size, made.texture_size);
    EXPECT_EQ(plan.page_count, made.page_count);
    EXPECT_EQ(plan.maxima_count, made.maxima_count);
    EXPECT_EQ(plan.origin, made.origin);
    EXPECT_TRUE(plan.texels.empty() && plan.pages.empty() && plan.maxima.empty());
    EXPECT_EQ(plan.gpu_bytes(), made.gpu_bytes());
    EXPECT_EQ(made.gpu_bytes(), made.texels.size() + 4 * made.pages.size());
}

TEST_P(GridField, IsZeroAtItsBoundsAndOutside)
{
    const auto& [layout, storage, channels] = GetParam();
    const VoxelGrid grid = random_grid(7, channels, 1);
    const GridLayout g = make_layout(grid, layout, storage.storage, {});
    EXPECT_EQ(g.field_min, grid.index_min - 1);
    EXPECT_EQ(g.field_max, grid.index_max + 1);
    for (glm::dvec3 p : probe_points(grid, 2000)) {
        const int axis = static_cast<int>(std::abs(p.x * 7919)) % 3;
        p[axis] = p[axis] < 0 ? g.field_min[axis] - 0.25 : g.field_max[axis];
        ASSERT_EQ(sample(g, p), glm::dvec3{0}) << p.x << ' ' << p.y << ' ' << p.z;
    }
}

INSTANTIATE_TEST_SUITE_P(Layouts, GridField, testing::ValuesIn(field_cases()),
                         [](const auto& test) {
                             const FieldCase& c = test.param;
                             return std::string(c.layout == Layout::dense ? "dense_" : "bricks_") +
                                    c.storage.name + (c.channels == 3 ? "_vec3" : "_scalar");
                         });

TEST(GridLayout, DenseAndBricksHoldTheSameField)
{
    const VoxelGrid grid = random_grid(8, 1, 1);
    for (const StorageCase& storage : kStorageCases) {
        const GridLayout dense = make_layout(grid, Layout::dense, storage.storage, {});
        const GridLayout bricks = make_layout(grid, Layout::bricks, storage.storage, {});
        // Constant pages are rounded as texels are, then to 22 bits of mantissa. Bytes are rounded
        // by the grid's scale here and by the brick's there, which is no more than the grid's.
        const double apart = storage.storage == Storage::r8 ? 1.0 / 255 * (1 + 1e-6) : 0x1p-23;
        for (const glm::dvec3& p : probe_points(grid, 20000))
            ASSERT_NEAR(sample(dense, p).x, sample(bricks, p).x, apart) << storage.name;
    }
}

TEST(GridLayout, HalfDataStayBitExact)
{
    // Every half there is up to the largest, denormals included: scaled by a power of two, and only
    // upwards, none may change.
    std::uint16_t next = 0;
    for (const float largest : {1.0f, 65504.0f, 0x1p-14f}) {
        VoxelGrid grid = grid_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 0, 0}}, 1, [&] {
            next = static_cast<std::uint16_t>((next + 31) % 0x7c00);
            const auto value = static_cast<float>(half_value(next));
            return value <= largest ? value : largest;
        });
        grid.values[100] = largest;
        finish(grid);
        grid.stored_as_half = true;
        ASSERT_EQ(grid.max_value, largest);
        const GridLayout g = make_layout(grid, Layout::dense, Storage::r16f, {});
        EXPECT_EQ(std::exp2(std::round(std::log2(g.value_scale))), g.value_scale);
        const VoxelLookup lookup(grid);
        for (int x = 0; x < 48; ++x)
            for (int y = 0; y < 16; ++y)
                for (int z = 0; z < 8; ++z)
                    ASSERT_EQ(sample(g, {x, y, z}).x, double{lookup.value({x, y, z}).x});
    }
}

TEST(GridLayout, HalfRoundsToNearestEven)
{
    // Beside and on the midpoints of halves, in half's normal range and below it. The largest value
    // is a half whose scale is 1, so that texels are plain halves.
    std::vector<float> values{65504.0f};
    for (const int half : {1, 2, 77, 1022, 1023, 1024, 1025, 15000, 15001, 30001}) {
        const double low = half_value(static_cast<std::uint16_t>(half));
        const double high = half_value(static_cast<std::uint16_t>(half + 1));
        const auto middle = static_cast<float>((low + high) / 2);
        values.insert(values.end(), {middle, std::nextafter(middle, 0.0f),
                                     std::nextafter(middle, 1e9f), static_cast<float>(low)});
    }
    std::size_t i = 0;
    VoxelGrid grid =
        grid_of({{0, 0, 0}}, 1, [&] { return i < values.size() ? values[i++] : 0.0f; });
    const GridLayout g = make_layout(grid, Layout::bricks, Storage::r16f, {});
    ASSERT_EQ(g.value_scale, 1.0f);
    for (std::size_t v = 0; v < values.size(); ++v) {
        // The neighbours found by search, ties to the even code.
        int code = 0;
        while (half_value(static_cast<std::uint16_t>(code + 1)) <= double{values[v]} &&
               code < 0x7bff)
            ++code;
        const double low = half_value(static_cast<std::uint16_t>(code));
        const double high = half_value(static_cast<std::uint16_t>(code + 1));
        const double below = double{values[v]} - low, above = high - double{values[v]};
        const bool up = below > above || (below == above && code % 2 == 1);
        const auto at = static_cast<int>(v);
        EXPECT_EQ(sample(g, {at % 8, at / 8 % 8, at / 64}).x, up ? high : low) << values[v];
    }
}

TEST(GridLayout, KeepsTheRangeOfTheValues)
{
    std::mt19937 random(3);
    std::uniform_real_distribution<float> uniform(0.01f, 1.0f);
    for (const float scale : {1e30f, 1e-30f, 1e-37f, 3e38f, 1.0f}) {
        const VoxelGrid grid =
            grid_of({{0, 0, 0}, {7, -3, 2}}, 1, [&] { return scale * uniform(random); });
        for (const StorageCase& storage : kStorageCases) {
            const GridLayout g = make_layout(grid, Layout::automatic, storage.storage, {});
            EXPECT_TRUE(std::isnormal(g.value_scale)) << scale;  // GPUs flush what is not
            const VoxelLookup lookup(grid);
            for (const glm::dvec3& p : probe_points(grid, 2000)) {
                const double want = lookup.sample(p).x;
                ASSERT_NEAR(sample(g, p).x, want,
                            storage.relative * want + storage.absolute * double{scale})
                    << storage.name << ' ' << scale;
                ASSERT_LE(sample(g, p).x, bound_at(g, p)) << storage.name << ' ' << scale;
            }
            for (const float m : g.maxima)
                ASSERT_TRUE(std::isfinite(m));
        }
    }
}

TEST(GridLayout, StorageIsFloatWhereMostValuesAreTooFaint)
{
    std::mt19937 random(4);
    std::uniform_real_distribution<float> uniform(0.1f, 1.0f);
    VoxelGrid grid = grid_of({{0, 0, 0}, {1, 0, 0}}, 1, [&] { return uniform(random); });
    EXPECT_EQ(plan_layout(grid, Layout::automatic, Storage::automatic, {}).storage, Storage::r8);

    for (std::size_t i = 0; i < 100; ++i)
        grid.values[i] = 1e-15f;  // a faint tail is lost to bytes, and matters to nobody
    finish(grid);
    EXPECT_EQ(plan_layout(grid, Layout::automatic, Storage::automatic, {}).storage, Storage::r16f);

    grid.values[700] = 1e12f;  // one hot voxel: half would flatten all the rest
    finish(grid);
    EXPECT_EQ(plan_layout(grid, Layout::automatic, Storage::automatic, {}).storage, Storage::r32f);
    const VoxelLookup lookup(grid);
    const GridLayout g = make_layout(grid, Layout::automatic, Storage::automatic, {});
    EXPECT_EQ(sample(g, {9, 1, 3}).x, double{lookup.value({9, 1, 3}).x});

    grid.stored_as_half = true;  // the file's own precision is all there is
    EXPECT_EQ(plan_layout(grid, Layout::automatic, Storage::automatic, {}).storage, Storage::r16f);
}

/// Bricks apart, each a third of an octave fainter than the one before, of values 0..1 of its
/// largest: 20 octaves in all, more than scales go down.
VoxelGrid fading_grid(float largest)
{
    std::mt19937 random(21);
    std::uniform_real_distribution<float> uniform(0, 1);
    std::vector<glm::ivec3> at;
    for (int b = 0; b < 60; ++b)
        at.push_back({2 * b, 0, 0});
    int drawn = 0;
    return grid_of(at, 1, [&] {
        const int b = drawn++ / static_cast<int>(kBrickVoxels);
        return largest * std::exp2(-static_cast<float>(b) / 3) * uniform(random);
    });
}

TEST(GridLayout, BytesErrByTheirBricksOwnScale)
{
    for (const float largest : {1.0f, 100.0f, 1e30f, 1e-30f}) {
        const VoxelGrid grid = fading_grid(largest);
        const VoxelLookup lookup(grid);
        const GridLayout g = make_layout(grid, Layout::bricks, Storage::r8, {});
        const double all{grid.max_value};
        double least_scale = 1, worst = 0;
        for (int i = 0; i < static_cast<int>(g.pages.size()); ++i) {
            const std::uint32_t page = g.pages[std::size_t(i)];
            if (page < kPageBrick)
                continue;
            const glm::ivec3 first =
                g.origin + 8 * glm::ivec3{i % g.page_count.x, i / g.page_count.x % g.page_count.y,
                                          i / (g.page_count.x * g.page_count.y)};
            const double most = largest_in(lookup, first), scale = all * scale_of(page);
            least_scale = std::min(least_scale, scale_of(page));
            ASSERT_GE(scale, most * (1 - 1e-7)) << "clips";
            ASSERT_LE(scale, std::max(1.125 * (1 + 1e-6) * most, 0x1.2p-16 * all * (1 + 1e-6)));
            ASSERT_LE(double{g.maxima[std::size_t(i)]}, (most + 0.5 / 255 * scale) * (1 + 0x1p-19));
            const glm::ivec3 slot{page & 255u, page >> 8 & 255u, page >> 16 & 255u};
            for (int v = 0; v < 729; ++v) {
                const glm::ivec3 at{v % 9, v / 9 % 9, v / 81};
                const double want{lookup.value(first + at).x};
                const double error = std::abs(scale * texel(g, slot * 9 + at).x - want);
                ASSERT_LE(error, 0.5 / 255 * scale * (1 + 1e-5)) << first.x << ' ' << v;
                ASSERT_LE(scale * texel(g, slot * 9 + at).x, double{g.maxima[std::size_t(i)]});
                worst = std::max(worst, error / scale);
            }
        }
        EXPECT_EQ(least_scale, 0x1.2p-16) << "the faintest bricks share the least scale";
        EXPECT_GT(worst, 0.4 / 255);
    }
}

TEST(GridLayout, BytesOfValuesThatAreHardlyFloatsAreFinite)
{
    const VoxelGrid grid = fading_grid(1e-42f);
    const GridLayout g = make_layout(grid, Layout::bricks, Storage::r8, {});
    for (const glm::dvec3& p : probe_points(grid, 2000))
        ASSERT_LE(sample(g, p).x, double{grid.max_value} * 1.2);
    for (const float m : g.maxima)
        ASSERT_TRUE(std::isfinite(m));
}

TEST(GridLayout, ScalesAreEighthsOfOctaves)
{
    for (int step = 0; step <= kScaleSteps; ++step)
        EXPECT_EQ(double{brick_scale(step)}, scale_of(static_cast<std::uint32_t>(step) << 24));
    EXPECT_EQ(brick_scale(0), 1.0f);
    EXPECT_EQ(brick_scale(8), 0.5f);
}

TEST(GridLayout, FloatsHaveNoScaleOfTheirBrick)
{
    const VoxelGrid grid = fading_grid(1);
    for (const Storage storage : {Storage::r16f, Storage::r32f})
        for (const std::uint32_t page : make_layout(grid, Layout::bricks, storage, {}).pages)
            EXPECT_EQ(page >> 24 & 127u, 0u);
}

TEST(GridLayout, AutomaticTakesBytesWhereTheyErrLittle)
{
    std::mt19937 random(22);
    std::uniform_real_distribution<float> uniform(0.05f, 1);
    std::vector<glm::ivec3> at;
    for (int b = 0; b < 20; ++b)
        at.push_back({2 * b, b % 3, b % 5});
    VoxelGrid grid = grid_of(at, 1, [&] { return uniform(random); });
    const auto plan = [&](Layout layout = Layout::automatic) {
        return plan_layout(grid, layout, Storage::automatic, {});
    };
    EXPECT_EQ(plan().layout, Layout::bricks);
    EXPECT_EQ(plan().storage, Storage::r8);
    EXPECT_EQ(plan().storage_reason.rfind("errs 0.", 0), 0u) << plan().storage_reason;
    EXPECT_EQ(plan(Layout::dense).storage, Storage::r8);

    // Bricks of any brightness are as good as one another.
    for (std::size_t i = 0; i < grid.values.size(); ++i)
        grid.values[i] *= std::exp2(-0.5f * static_cast<float>(i / kBrickVoxels));
    finish(grid);
    EXPECT_EQ(plan().storage, Storage::r8) << plan().storage_reason;
    EXPECT_EQ(plan(Layout::dense).storage, Storage::r16f)
        << "bytes of one scale lose what is faint";

    // But a voxel that is 10^6 times its neighbours flattens them, though by RMS all is well.
    for (std::size_t b = 0; b < at.size(); ++b)
        grid.values[b * kBrickVoxels + 77] *= 1e6f;
    finish(grid);
    EXPECT_EQ(plan().storage, Storage::r16f);
    EXPECT_EQ(plan().storage_reason.rfind("R8 would err 0.", 0), 0u) << plan().storage_reason;
    EXPECT_EQ(plan_layout(grid, Layout::bricks, Storage::r8, {}).storage_reason, "asked for");
}

TEST(GridLayout, AutomaticTakesBytesOfColoursToo)
{
    std::mt19937 random(24);
    std::uniform_real_distribution<float> uniform(0.2f, 1);
    VoxelGrid grid = grid_of({{0, 0, 0}, {9, 0, 0}, {0, 9, 9}}, 3, [&] { return uniform(random); });
    const auto storage = [&] {
        return plan_layout(grid, Layout::automatic, Storage::automatic, {}).storage;
    };
    EXPECT_EQ(storage(), Storage::r8);
    for (std::size_t i = 0; i < grid.values.size(); i += 3)
        grid.values[i] *= 1e-3f;  // red beside green and blue, whose scale it has
    finish(grid);
    EXPECT_EQ(storage(), Storage::r16f);
}

/// Full bricks of 8 x 8 columns as high as `layers`, and the last of 8^3. faint: by how many
/// octaves each is fainter than the one before, of eight in turns.
VoxelGrid cube_of_bricks(int layers, float faint)
{
    std::mt19937 random(23);
    std::vector<glm::ivec3> solid;
    for (int i = 0; i < 64 * layers; ++i)
        solid.push_back({i % 8, i / 8 % 8, i / 64});
    if (layers < 8)
        solid.push_back({7, 7, 7});
    int drawn = 0;
    return grid_of(solid, 1, [&] {
        const int b = drawn++ / static_cast<int>(kBrickVoxels);
        return std::exp2(-faint * static_cast<float>(b % 8)) * float(random() % 100 + 1);
    });
}

TEST(GridLayout, SomewhatSmallerBricksAreNoReasonAgainstDense)
{
    // 66^3 texels dense, 9^3 * 729 as bricks.
    const GridLayout even =
        plan_layout(cube_of_bricks(8, 0), Layout::automatic, Storage::automatic, {});
    EXPECT_EQ(even.layout, Layout::dense);
    EXPECT_EQ(even.storage, Storage::r8);

    // With one scale bytes lose what is faint; with a brick's own they don't, and are fewer.
    const VoxelGrid fading = cube_of_bricks(8, 2);
    const GridLayout plan = plan_layout(fading, Layout::automatic, Storage::automatic, {});
    EXPECT_EQ(plan.layout, Layout::dense);
    EXPECT_EQ(plan.storage, Storage::r16f);
    EXPECT_EQ(plan.storage_reason.rfind("R8 would err ", 0), 0u) << plan.storage_reason;
    const std::uint64_t bytes =
        plan_layout(fading, Layout::bricks, Storage::automatic, {}).gpu_bytes();
    EXPECT_LT(bytes, plan.gpu_bytes());
    // Where dense does not fit, they are what does.
    const GridLayout small =
        plan_layout(fading, Layout::automatic, Storage::automatic, {2048, bytes});
    EXPECT_EQ(small.layout, Layout::bricks);
    EXPECT_EQ(small.storage, Storage::r8);
}

TEST(GridLayout, ManyFewerBytesAreAReasonAgainstDense)
{
    // Dense is fewer halves than bricks are, but bricks as bytes are fewer by far.
    const VoxelGrid grid = cube_of_bricks(5, 2);
    const auto bytes = [&](Layout layout, Storage storage) {
        return plan_layout(grid, layout, storage, {}).gpu_bytes();
    };
    ASSERT_LT(bytes(Layout::dense, Storage::r16f), bytes(Layout::bricks, Storage::r16f));
    const GridLayout plan = plan_layout(grid, Layout::automatic, Storage::automatic, {});
    EXPECT_EQ(plan.layout, Layout::bricks);
    EXPECT_EQ(plan.storage, Storage::r8);
    EXPECT_EQ(plan_layout(cube_of_bricks(5, 0), Layout::automatic, Storage::automatic, {}).layout,
              Layout::dense);
}

TEST(GridLayout, OneScaleIsWeighedWithItsConstants)
{
    // A bright brick beside tiles that one scale can't hold: 1 / 1000 of it is a quarter of a step.
    VoxelGrid grid = grid_of({{0, 0, 0}}, 1, [] { return 1.0f; });
    grid.tiles = {{{1, 0, 0}, {1, 3, 3}, {0.001f, 0, 0}}};
    finish(grid);
    EXPECT_EQ(plan_layout(grid, Layout::dense, Storage::automatic, {}).storage, Storage::r16f);
    grid.tiles[0].value.x = 0.5f;
    finish(grid);
    EXPECT_EQ(plan_layout(grid, Layout::dense, Storage::automatic, {}).storage, Storage::r8);
}

TEST(GridLayout, AtlasEndsWherePagesCanNameIt)
{
    // 71^3 pages of colour, all bricks, on a GL that would take an edge of 1820.
    VoxelGrid grid;
    grid.name = "color";
    grid.channels = 3;
    grid.tiles = {{{0, 0, 0}, {69, 69, 69}, {0.3f, 0.2f, 0.1f}}};
    finish(grid);
    const GridLayout plan =
        plan_layout(grid, Layout::bricks, Storage::r16f, {.max_texture_3d = 16384});
    const glm::ivec3 slots = plan.texture_size / 9;
    EXPECT_GE(slots.x * slots.y * slots.z, 71 * 71 * 71);
    EXPECT_LE(std::max({slots.x, slots.y, slots.z}), kMostSlotsPerAxis);
}

TEST(GridLayout, ApronReachesIntoPagesBeforeTheContent)
{
    // One voxel, first of its brick: the field lies in 8 pages, of which 7 hold no brick.
    VoxelGrid grid = grid_of({{0, 0, 0}}, 1, [] { return 0.0f; });
    grid.values[0] = 2;
    finish(grid);
    const GridLayout g = make_layout(grid, Layout::bricks, Storage::r32f, {});
    EXPECT_EQ(g.page_count, glm::ivec3(2));
    EXPECT_EQ(g.origin, glm::ivec3(-8));
    EXPECT_EQ(std::count_if(g.pages.begin(), g.pages.end(),
                            [](std::uint32_t p) { return p >= kPageBrick; }),
              8);
    EXPECT_DOUBLE_EQ(sample(g, {-0.5, -0.25, -0.5}).x, 2 * 0.5 * 0.75 * 0.5);
    // The last voxel of a brick lies in one page alone.
    grid.values[0] = 0;
    grid.values[511] = 2;
    grid.index_min = glm::ivec3{1}, grid.index_max = glm::ivec3{0};
    finish(grid);
    EXPECT_EQ(make_layout(grid, Layout::bricks, Storage::r32f, {}).page_count, glm::ivec3(1));
}

TEST(GridLayout, ConstantInsideOfATileTakesNoTexels)
{
    VoxelGrid grid;
    grid.name = "density";
    grid.tiles = {{{-10, -10, -10}, {9, 9, 9}, glm::vec3{0.3f}}};
    finish(grid);
    const GridLayout g = make_layout(grid, Layout::bricks, Storage::r16f, {});
    std::size_t constants = 0, bricks = 0;
    for (const std::uint32_t page : g.pages)
        ++(page >= kPageBrick ? bricks : constants);
    EXPECT_EQ(std::count(g.pages.begin(), g.pages.end(), 0u), 0);
    EXPECT_EQ(constants, 19u * 19 * 19);
    EXPECT_EQ(bricks, 21u * 21 * 21 - 19 * 19 * 19);  // the rim to 0
    EXPECT_LT(g.gpu_bytes(), 21u * 21 * 21 * 1000);
}

TEST(GridLayout, AtlasWastesLittleAndIsNearlyACube)
{
    std::mt19937 random(5);
    for (const int bricks : {1, 2, 3, 7, 23, 101, 997, 2503}) {
        std::vector<glm::ivec3> at;
        for (int i = 0; i < bricks; ++i)  // apart, so that each takes 8 slots
            at.push_back({2 * (i % 16), 2 * (i / 16 % 16), 2 * (i / 256)});
        const VoxelGrid grid = grid_of(at, 1, [&] { return float(random() % 100 + 1); });
        const GridLayout g = make_layout(grid, Layout::bricks, Storage::r8, {});
        const glm::ivec3 slots = g.texture_size / 9;
        EXPECT_EQ(slots * 9, g.texture_size);
        EXPECT_LE(slots.x * slots.y * slots.z, 8 * bricks * 1.03) << bricks;
        const double cube = std::ceil(std::cbrt(8 * bricks));
        EXPECT_LE(std::max({slots.x, slots.y, slots.z}), 4 * cube) << bricks;
        std::vector<std::uint32_t> used;
        for (const std::uint32_t page : g.pages)
            if (page >= kPageBrick)
                used.push_back(page & 0xffffffu);
        std::sort(used.begin(), used.end());
        EXPECT_EQ(used.size(), 8u * static_cast<std::size_t>(bricks));
        EXPECT_EQ(std::adjacent_find(used.begin(), used.end()), used.end());  // no slot twice
    }
}

TEST(GridLayout, ChoosesTheSmallerLayoutThatFits)
{
    std::mt19937 random(6);
    const auto value = [&] { return float(random() % 100 + 1); };
    std::vector<glm::ivec3> solid;
    for (int i = 0; i < 64; ++i)
        solid.push_back({i % 4, i / 4 % 4, i / 16});
    const VoxelGrid full = grid_of(solid, 1, value);
    const VoxelGrid sparse = grid_of({{0, 0, 0}, {20, 20, 20}}, 1, value);
    const auto choose = [](const VoxelGrid& grid, const Limits& limits) {
        return plan_layout(grid, Layout::automatic, Storage::r16f, limits).layout;
    };
    EXPECT_EQ(choose(full, {}), Layout::dense);
    EXPECT_EQ(choose(sparse, {}), Layout::bricks);
    // Dense is 130 texels long where the GL takes 64; the atlas folds.
    std::vector<glm::ivec3> row;
    for (int i = 0; i < 16; ++i)
        row.push_back({i, 0, 0});
    EXPECT_EQ(choose(grid_of(row, 1, value), {}), Layout::dense);
    EXPECT_EQ(choose(grid_of(row, 1, value), {.max_texture_3d = 64}), Layout::bricks);

    for (const VoxelGrid* grid : {&full, &sparse}) {
        const GridLayout plan = plan_layout(*grid, Layout::automatic, Storage::r16f, {});
        for (const Layout other : {Layout::dense, Layout::bricks})
            EXPECT_LE(plan.gpu_bytes(), plan_layout(*grid, other, Storage::r16f, {}).gpu_bytes());
        // The limit itself is allowed, one byte less is not.
        const std::uint64_t bytes = plan.gpu_bytes();
        EXPECT_EQ(plan_layout(*grid, plan.layout, Storage::r16f, {2048, bytes}).gpu_bytes(), bytes);
        EXPECT_THROW(plan_layout(*grid, plan.layout, Storage::r16f, {2048, bytes - 1}), Error);
    }
}

std::string refusal(const VoxelGrid& grid, Layout layout, const Limits& limits)
{
    try {
        make_layout(grid, layout, Storage::automatic, limits);
    } catch (const Error& error) {
        return error.what();
    }
    return "";
}

/// A grid whose parts lie far apart: the same one again at an offset in bricks.
VoxelGrid with_far_copy(const VoxelGrid& grid, const glm::ivec3& offset)
{
    VoxelGrid both = grid;
    std::vector<std::pair<glm::ivec3, std::size_t>> bricks;
    for (std::size_t i = 0; i < grid.bricks.size(); ++i) {
        bricks.emplace_back(grid.bricks[i], i);
        bricks.emplace_back(grid.bricks[i] + offset, i);
    }
    std::sort(bricks.begin(), bricks.end(),
              [](const auto& a, const auto& b) { return before(a.first, b.first); });
    both.bricks.clear();
    both.values.clear();
    const std::size_t stride = kBrickVoxels * static_cast<std::size_t>(grid.channels);
    for (const auto& [brick, from] : bricks) {
        both.bricks.push_back(brick);
        both.values.insert(both.values.end(),
                           grid.values.begin() + static_cast<std::ptrdiff_t>(from * stride),
                           grid.values.begin() + static_cast<std::ptrdiff_t>((from + 1) * stride));
    }
    for (VoxelTile tile : grid.tiles) {
        tile.brick_min += offset;
        tile.brick_max += offset;
        both.tiles.push_back(tile);
    }
    finish(both);
    return both;
}

TEST(PageTree, FarPartsAreEachSampledAsTheGridIs)
{
    const glm::ivec3 offset(25000, -3000, 65000);
    for (const StorageCase& storage : kStorageCases)
        for (const int channels : {1, 3}) {
            const VoxelGrid near = random_grid(3, channels, 1.7f);
            const VoxelGrid grid = with_far_copy(near, offset);
            const VoxelLookup lookup(grid);
            const GridLayout g = make_layout(grid, Layout::automatic, storage.storage, {});
            ASSERT_GT(g.tree.levels, 0);
            EXPECT_LT(g.gpu_bytes(), std::uint64_t{16} << 20);
            std::vector<glm::dvec3> points = probe_points(near, 10000);
            for (const glm::dvec3& p : probe_points(near, 10000))
                points.push_back(p + glm::dvec3(8 * offset));
            int inside = 0;
            for (const glm::dvec3& p : points) {
                const glm::dvec3 want = lookup.sample(p), got = sample(g, p);
                inside += want.x > 0 ? 1 : 0;
                // Texel coordinates of 5e5 carry 2^-33 of rounding into the weights.
                const double absolute =
                    storage.absolute * scale_at(g, lookup, grid, p) + 0x1p-30 * 1.7;
                for (int c = 0; c < 3; ++c)
                    ASSERT_LE(std::abs(got[c] - want[c]), storage.relative * want[c] + absolute)
                        << storage.name << " channel " << c << " at " << p.x << ' ' << p.y << ' '
                        << p.z;
            }
            EXPECT_GT(inside, 3000);
        }
}

TEST(PageTree, AsFarApartAsIndicesReach)
{
    VoxelGrid grid = grid_of({{0, 0, 0}, {1, 1, 1}}, 1, [] { return 1.0f; });
    grid.bricks = {glm::ivec3{-(1 << 27)}, glm::ivec3{(1 << 27) - 1}};
    finish(grid);
    const GridLayout g = make_layout(grid, Layout::automatic, Storage::automatic, {});
    EXPECT_EQ(g.tree.levels, 10);
    EXPECT_LT(g.gpu_bytes(), 200u * 1024);
    for (const glm::dvec3 at : {glm::dvec3(-(1 << 30)), glm::dvec3((1 << 30) - 1)}) {
        EXPECT_EQ(sample(g, at).x, 1);
        EXPECT_NEAR(sample(g, at + glm::dvec3(0.5, 0, 0)).x, at.x < 0 ? 1 : 0.5, 1e-6);
    }
    EXPECT_EQ(sample(g, {0, 0, 0}).x, 0);
}

TEST(PageTree, LargeTilesAreAFewBricks)
{
    for (const int dim : {512, 2048}) {  // bricks along the edge: 4096^3 and 16384^3 voxels
        VoxelGrid grid;
        grid.name = "density";
        const int n = dim / 512;
        for (int i = 0; i < n * n * n; ++i) {  // as files have them
            const glm::ivec3 at = 512 * glm::ivec3(i % n, i / n % n, i / (n * n));
            grid.tiles.push_back({at, at + 511, glm::vec3{0.5f}});
        }
        finish(grid);
        const GridLayout g = make_layout(grid, Layout::automatic, Storage::automatic, {});
        // A page at each face, edge and corner; a node for each on every level.
        EXPECT_EQ(g.tree.leaves.size(), 26u);
        EXPECT_LE(g.tree.nodes.size(), std::size_t(27 * g.tree.levels));
        EXPECT_LT(g.gpu_bytes(), std::uint64_t{1} << 20);
        const double end = 8 * dim - 1;
        EXPECT_NEAR(sample(g, {1, 2000.5, 3}).x, 0.5, 1e-6);
        EXPECT_NEAR(sample(g, {0, 0, 0}).x, 0.5, 1e-6);
        EXPECT_NEAR(sample(g, {end, end, end}).x, 0.5, 1e-6);
        EXPECT_NEAR(sample(g, {-0.25, 1234.5, 77}).x, 0.375, 1e-6);
        EXPECT_NEAR(sample(g, {end + 0.25, 1234.5, 77}).x, 0.375, 1e-6);
        EXPECT_NEAR(sample(g, {end + 0.5, 12, end + 0.5}).x, 0.125, 1e-6);
        EXPECT_EQ(sample(g, {end + 1, 12, 77}).x, 0);
    }
}

TEST(PageTree, OccupiedBoxesHoldAllAndAreFew)
{
    const VoxelGrid near = random_grid(5, 1, 0.83f);
    const glm::ivec3 offset(25000, 0, 0);
    const VoxelGrid grid = with_far_copy(near, offset);
    const GridLayout g = make_layout(grid, Layout::automatic, Storage::r16f, {});
    for (const std::size_t limit : {std::size_t{4096}, std::size_t{40}}) {
        const std::vector<OccupiedBox> boxes = occupied_boxes(g, limit);
        EXPECT_LE(boxes.size(), limit);
        double filled = 0;
        for (const OccupiedBox& box : boxes) {
            const glm::dvec3 size = box.bounds.max - box.bounds.min;
            filled += size.x * size.y * size.z;
        }
        // Two of 72 x 56 x 56 voxels at most.
        EXPECT_LT(filled, 2 * 74 * 58 * 58);
        for (const glm::dvec3& p : probe_points(near, 5000)) {
            const double value = sample(g, p).x;
            const glm::dvec3 q = p - glm::dvec3(g.origin);
            double most = 0;
            for (const OccupiedBox& box : boxes)
                if (glm::all(glm::greaterThanEqual(q, box.bounds.min - 1e-6)) &&
                    glm::all(glm::lessThanEqual(q, box.bounds.max + 1e-6)))
                    most = std::max(most, double{box.most});
            ASSERT_LE(value, most) << p.x << ' ' << p.y << ' ' << p.z;
        }
    }
    const std::vector<Bounds> apart = islands(occupied_boxes(g, 4096), 8);
    ASSERT_EQ(apart.size(), 2u);
    EXPECT_EQ(apart[0].min + glm::dvec3(8 * offset), apart[1].min);
    EXPECT_EQ(apart[0].max + glm::dvec3(8 * offset), apart[1].max);
}

TEST(PageTree, IslandsAreBoxesOfTheirOwn)
{
    std::vector<OccupiedBox> boxes;
    std::mt19937 random(4);
    std::uniform_real_distribution<double> place(0, 5e5);
    for (int i = 0; i < 40; ++i) {
        OccupiedBox box;
        box.bounds.add(glm::dvec3(place(random), place(random), place(random)));
        box.bounds.add(box.bounds.min + 2.0);
        boxes.push_back(box);
    }
    EXPECT_EQ(islands(boxes, 48).size(), 40u);
    EXPECT_EQ(islands(boxes, 7).size(), 7u);
    boxes.resize(1);
    EXPECT_EQ(islands(boxes, 48).size(), 1u);
    EXPECT_TRUE(islands({}, 48).empty());
}

TEST(GridLayout, RefusesWhatDoesNotFitWithSizeAndRemedy)
{
    // Two voxels 2^30 apart: 10^27 bytes dense. Allocating would end the test.
    const int far = 1 << 26;
    VoxelGrid grid = grid_of({{-far, -far, -far}, {far, far, far}}, 1, [] { return 1.0f; });
    const std::string message = refusal(grid, Layout::dense, {});
    EXPECT_NE(message.find("density: 1073741832 x 1073741832 x 1073741832 voxels take "),
              std::string::npos)
        << message;
    EXPECT_NE(message.find("4.0 GiB"), std::string::npos) << message;
    EXPECT_NE(message.find("resample the grid coarser"), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    // A tree of pages that has no room either.
    EXPECT_NE(refusal(grid, Layout::automatic, {.max_bytes = 20000}).find("resample the grid"),
              std::string::npos);
    // As far apart as indices reach: 2^32 voxels along an edge, which no int holds.
    grid.bricks = {glm::ivec3{-(1 << 28)}, glm::ivec3{(1 << 28) - 1}};
    finish(grid);
    EXPECT_NE(refusal(grid, Layout::dense, {}).find("4294967296 x "), std::string::npos);
    EXPECT_THROW(plan_layout(grid, Layout::dense, Storage::automatic, {}), Error);
}

TEST(GridLayout, RefusalNamesTheLayoutThatWouldDo)
{
    std::mt19937 random(8);
    const VoxelGrid sparse =
        grid_of({{0, 0, 0}, {40, 40, 1}}, 1, [&] { return float(random() % 9); });
    const Limits limits{.max_texture_3d = 2048, .max_bytes = 256 * 1024};
    const std::string message = refusal(sparse, Layout::dense, limits);
    EXPECT_NE(message.find("take 3.7 MiB dense, over the limit of 256.0 KiB"), std::string::npos)
        << message;
    EXPECT_NE(message.find("lay it out as bricks"), std::string::npos) << message;
    EXPECT_EQ(refusal(sparse, Layout::automatic, limits), "");
}

TEST(GridLayout, RefusesAnAtlasOfTooManySlots)
{
    // 8 slots are needed where an edge of 9 texels allows one.
    const VoxelGrid grid = grid_of({{0, 0, 0}}, 1, [] { return 1.0f; });
    const std::string message = refusal(grid, Layout::bricks, {.max_texture_3d = 9});
    EXPECT_NE(message.find("9 texels along an edge"), std::string::npos) << message;
}

TEST(GridLayout, EmptyGridIsAnEmptyLayout)
{
    VoxelGrid grid;
    grid.name = "density";
    EXPECT_TRUE(grid.empty());
    EXPECT_EQ(plan_layout(grid, Layout::automatic, Storage::automatic, {}).gpu_bytes(), 0u);
    const GridLayout g = make_layout(grid, Layout::bricks, Storage::automatic, {});
    EXPECT_EQ(g.gpu_bytes(), 0u);
    EXPECT_TRUE(g.texels.empty() && g.pages.empty() && g.maxima.empty());
}

TEST(GridLayout, HugeTilePlansInPages)
{
    VoxelGrid grid;
    grid.name = "density";
    grid.tiles = {{{0, 0, 0}, {127, 127, 127}, glm::vec3{0.5f}}};  // 1024^3 voxels
    finish(grid);
    const GridLayout plan = plan_layout(grid, Layout::automatic, Storage::r16f, {});
    EXPECT_EQ(plan.layout, Layout::bricks);
    EXPECT_EQ(plan.page_count, glm::ivec3(129));
    EXPECT_LT(plan.gpu_bytes(), std::uint64_t{170} << 20);  // dense: 2 GiB
}

}  // namespace

}  // namespace fumarole::medium
