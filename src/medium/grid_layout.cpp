#include "medium/grid_layout.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <functional>
#include <glm/gtc/type_precision.hpp>
#include <limits>
#include <optional>
#include <string>

#include "medium/grid_cells.h"
#include "shared/brick_page.h"
#include <fumarole/errors.h>

namespace fumarole::medium {

namespace {

using shared::is_brick;
using shared::kPageBrick;

constexpr int kBrickDim = VoxelGrid::kBrickDim;
constexpr float kHalfMax = 65504.0f;
constexpr float kHalfMinNormal = 0x1p-14f;

// Filtering and scaling on the GPU round to float once or twice each, so a sample may stand a few
// 2^-24 above the largest value it was made of; a bound has to stand above that.
constexpr float kMaximaMargin = 1.0f + 0x1p-20f;

// What automatic takes for small. RMS is what a picture shows, where the errors of a ray's voxels,
// of either sign, nearly cancel; a march errs by 2 % itself. But RMS does not see a few huge values
// flatten what is around them, which a coefficient brings back to sight: so what a value loses of
// itself is bounded too, on the mean. Smoke, fire and clouds have 0.1 to 0.3 % and 0.4 to 3.4 %.
constexpr double kSmallRms = 0.005, kSmallMean = 0.05;

/// A dense texture is fetched faster, by a tenth to a quarter; bricks of this part of its bytes are
/// taken all the same.
constexpr double kManyFewerBytes = 2.0 / 3.0;

std::int64_t floor_div(std::int64_t a, std::int64_t b)
{
    return a / b - (a % b < 0 ? 1 : 0);
}

/// Where a grid lies, in 64 bits: nothing here overflows whatever the indices are.
struct Frame {
    glm::i64vec3 field_min, field_max;
    glm::i64vec3 dense_size;  ///< texels, the rim of zeros included
    glm::i64vec3 first_page,
        page_count;  ///< first page and number of pages of all cells that can hold a value

    explicit Frame(const VoxelGrid& grid)
    {
        const glm::i64vec3 lo = grid.index_min, hi = grid.index_max;
        field_min = lo - std::int64_t{1};
        field_max = hi + std::int64_t{1};
        dense_size = field_max - field_min + std::int64_t{1};
        for (int axis = 0; axis < 3; ++axis) {
            // Voxel 8b is the first of page b and the apron of page b - 1.
            first_page[axis] = floor_div(lo[axis] - 1, kBrickDim);
            page_count[axis] = floor_div(hi[axis], kBrickDim) - first_page[axis] + 1;
        }
    }
};

/// Exact up to 2^53, which is past every limit, and no overflow beyond.
double volume(const glm::i64vec3& size)
{
    return static_cast<double>(size.x) * static_cast<double>(size.y) * static_cast<double>(size.z);
}

std::size_t volume(const glm::ivec3& size)
{
    return static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) *
           static_cast<std::size_t>(size.z);
}

std::size_t linear(const glm::ivec3& at, const glm::ivec3& size)
{
    return (static_cast<std::size_t>(at.z) * static_cast<std::size_t>(size.y) +
            static_cast<std::size_t>(at.y)) *
               static_cast<std::size_t>(size.x) +
           static_cast<std::size_t>(at.x);
}

glm::ivec3 unlinear(std::size_t i, const glm::ivec3& size)
{
    const auto x = static_cast<std::size_t>(size.x), y = static_cast<std::size_t>(size.y);
    return {static_cast<int>(i % x), static_cast<int>(i / x % y), static_cast<int>(i / (x * y))};
}

std::size_t bytes_per_value(Storage storage)
{
    return storage == Storage::r32f ? 4 : storage == Storage::r16f ? 2 : 1;
}

/// To the nearest half, ties to even. For 0 <= value <= kHalfMax.
std::uint16_t half_from_float(float value)
{
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(value) & 0x7fffffffu;  // no -0
    if (bits < (113u << 23)) {  // below 2^-14: half has no exponent left
        // An ulp of 0.5f is 2^-24, half's smallest step, so the sum rounds where half does.
        return static_cast<std::uint16_t>(std::bit_cast<std::uint32_t>(value + 0.5f) -
                                          std::bit_cast<std::uint32_t>(0.5f));
    }
    const std::uint32_t odd = (bits >> 13) & 1u;
    return static_cast<std::uint16_t>((bits - (112u << 23) + 0xfffu + odd) >> 13);
}

float float_from_half(std::uint16_t half)
{
    const int exponent = half >> 10;
    const auto mantissa = static_cast<float>(half & 0x3ff);
    return exponent == 0 ? std::ldexp(mantissa, -24) : std::ldexp(mantissa + 1024, exponent - 25);
}

/// Of values rounded to bytes: what a ByteError is made of.
struct ByteSums {
    double error2 = 0, value2 = 0, relative = 0, values = 0;

    ByteSums operator+(const ByteSums& b) const
    {
        return {error2 + b.error2, value2 + b.value2, relative + b.relative, values + b.values};
    }
};

/// From the grid's values to texels.
class Encoder {
public:
    Encoder(Storage storage, int channels, float value_scale)
        : storage_(storage), channels_(channels), value_scale_(value_scale)
    {
    }

    [[nodiscard]] std::size_t texel_bytes() const
    {
        return bytes_per_value(storage_) * (channels_ == 3 ? 4 : 1);
    }

    /// For the texels of a brick of that scale.
    [[nodiscard]] Encoder of_brick(float brick_scale) const
    {
        return {storage_, channels_,
                std::max(value_scale_ * brick_scale, std::numeric_limits<float>::denorm_min())};
    }

    /// What a fetch of this value gives, times value_scale. Grows with `value`.
    [[nodiscard]] float decoded(float value) const { return stored(value) * value_scale_; }

    /// What a page that is all this value gives: a page is no texel, so bytes need not round it.
    [[nodiscard]] float constant(float value) const
    {
        return storage_ == Storage::r8 ? value / value_scale_ : stored(value);
    }

    /// What a fetch of this value gives.
    [[nodiscard]] float stored(float value) const
    {
        switch (storage_) {
        case Storage::r16f:
            return float_from_half(to_half(value));
        case Storage::r8:
            return static_cast<float>(to_unorm(value)) / 255.0f;
        default:
            return to_float(value);
        }
    }

    /// Of r8, what rounding does to these voxels, whose scale is `unit` of the sums' own.
    [[nodiscard]] ByteSums byte_sums(const float* values, int voxels, double unit) const
    {
        float error2 = 0, value2 = 0, relative = 0;
        int count = 0;
        for (int i = 0; i < voxels * channels_; ++i) {
            const float value = values[i] / value_scale_;
            const float error = static_cast<float>(to_unorm(values[i])) / 255.0f - value;
            error2 += error * error;
            value2 += value * value;
            if (value > 0) {
                relative += std::abs(error) / value;
                ++count;
            }
        }
        const double unit2 = unit * unit;
        return {error2 * unit2, value2 * unit2, double{relative}, double(count)};
    }

    void encode(const float* values, int voxels, std::uint8_t* texels) const
    {
        switch (storage_) {
        case Storage::r16f:
            return encode_each(values, voxels, texels, [this](float v) { return to_half(v); });
        case Storage::r8:
            return encode_each(values, voxels, texels, [this](float v) { return to_unorm(v); });
        default:
            return encode_each(values, voxels, texels, [this](float v) { return to_float(v); });
        }
    }

private:
    [[nodiscard]] float to_float(float value) const { return value / value_scale_; }
    [[nodiscard]] std::uint16_t to_half(float value) const
    {
        return half_from_float(std::min(value / value_scale_, kHalfMax));
    }
    [[nodiscard]] std::uint8_t to_unorm(float value) const
    {
        // NOLINTNEXTLINE(bugprone-incorrect-roundings): never below 0, and for every voxel.
        return static_cast<std::uint8_t>(std::min(value / value_scale_, 1.0f) * 255.0f + 0.5f);
    }

    template <class Convert>
    void encode_each(const float* values, int voxels, std::uint8_t* texels, Convert convert) const
    {
        using Texel = decltype(convert(0.0f));
        const auto put = [&](Texel texel) {
            std::memcpy(texels, &texel, sizeof texel);
            texels += sizeof texel;
        };
        if (channels_ == 1) {
            for (int i = 0; i < voxels; ++i)
                put(convert(values[i]));
            return;
        }
        for (int i = 0; i < voxels; ++i, values += 3) {
            for (int c = 0; c < 3; ++c)
                put(convert(values[c]));
            put(0);
        }
    }

    Storage storage_;
    int channels_;  // of the grid
    float value_scale_;
};

/// What stands in each brick, addressed without a search, and the cells read through it.
class CellReader {
public:
    CellReader(const VoxelGrid& grid, const Frame& frame)
        : grid_(grid), first_(frame.first_page), count_(frame.page_count), source_(volume(count_))
    {
        const glm::ivec3 last = first_ + count_ - 1;
        for (std::size_t i = 0; i < grid.bricks.size(); ++i) {
            const glm::ivec3 at = grid.bricks[i];
            // A brick of zeros may lie outside the bounds of what is not 0.
            if (glm::all(glm::greaterThanEqual(at, first_)) &&
                glm::all(glm::lessThanEqual(at, last)))
                source_[linear(at - first_, count_)] = static_cast<int>(i) + 1;
        }
        for (std::size_t i = 0; i < grid.tiles.size(); ++i) {
            const glm::ivec3 lo = glm::max(grid.tiles[i].brick_min, first_);
            const glm::ivec3 hi = glm::min(grid.tiles[i].brick_max, last);
            for (int z = lo.z; z <= hi.z; ++z)
                for (int y = lo.y; y <= hi.y; ++y)
                    for (int x = lo.x; x <= hi.x; ++x)
                        source_[linear(glm::ivec3{x, y, z} - first_, count_)] =
                            -static_cast<int>(i) - 1;
        }
    }

    void read(const glm::ivec3& page, Cell& cell) const
    {
        CellSources sources;
        for (int corner = 0; corner < 8; ++corner)
            sources[static_cast<std::size_t>(corner)] = source(page + corner_offset(corner));
        read_cell(grid_, sources, cell);
    }

private:
    /// 0 for nothing, brick + 1, or -(tile + 1).
    [[nodiscard]] int source(const glm::ivec3& page) const
    {
        return glm::any(glm::greaterThanEqual(page, count_)) ? 0 : source_[linear(page, count_)];
    }

    const VoxelGrid& grid_;
    glm::ivec3 first_, count_;
    std::vector<int> source_;
};

/// Calls f(page index, position) for all pages, on all cores.
template <class F> void for_each_page(const glm::ivec3& count, F f)
{
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, volume(count), 64),
                      [&](const auto& range) {
                          Cell cell;
                          for (std::size_t i = range.begin(); i != range.end(); ++i)
                              f(i, unlinear(i, count), cell);
                      });
}

/// The power of two that brings the largest value to 2^15..65504, the top of half's range: what is
/// below it then keeps its 11 bits down to 2^-29 of it, and halves from a file stay themselves.
float half_value_scale(float max_value)
{
    if (max_value <= 0)
        return 1;
    int exponent = std::ilogb(max_value) - 15;
    if (std::ldexp(max_value, -exponent) > kHalfMax)
        ++exponent;
    // A smaller one would not be a normal float, and GPUs take those for 0.
    return std::ldexp(1.0f, std::max(exponent, std::numeric_limits<float>::min_exponent - 1));
}

/// Where texels are floats: r16f, unless most of what the grid holds lies under the range in which
/// half has its 11 bits: a few voxels 10^9 times the rest (a spike in an emission grid, say) would
/// cost the rest its shape. A faint tail under a normal grid is no such case: it is 2^-29 of the
/// largest value and unseen.
Storage float_storage(const VoxelGrid& grid)
{
    if (grid.stored_as_half)
        return Storage::r16f;
    struct Count {
        double present = 0, faint = 0;
    };
    const float least = kHalfMinNormal * half_value_scale(grid.max_value);
    const auto add = [least](Count& count, float value, double voxels) {
        count.present += value > 0 ? voxels : 0;
        count.faint += value > 0 && value < least ? voxels : 0;
    };
    Count all = tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, grid.values.size(), 1 << 16), Count{},
        [&](const auto& range, Count count) {
            for (std::size_t i = range.begin(); i != range.end(); ++i)
                add(count, grid.values[i], 1);
            return count;
        },
        [](const Count& a, const Count& b) {
            return Count{a.present + b.present, a.faint + b.faint};
        });
    for (const VoxelTile& tile : grid.tiles) {
        const double bricks =
            volume(glm::i64vec3(tile.brick_max) - glm::i64vec3(tile.brick_min) + std::int64_t{1});
        for (int c = 0; c < grid.channels; ++c)
            add(all, tile.value[c], bricks * VoxelGrid::kBrickVoxels);
    }
    return all.faint > 0.5 * all.present ? Storage::r32f : Storage::r16f;
}

std::string automatic_reason(Storage storage, const std::optional<ByteError>& error)
{
    if (error)
        return fmt::format("{} {:.2g} % of the RMS, {:.2g} % of a value",
                           storage == Storage::r8 ? "errs" : "R8 would err", 100 * error->rms,
                           100 * error->mean);
    return "most values are too faint for half floats beside the largest";
}

/// From the largest value of what is stored, that of what is sampled.
float bound(float stored_max)
{
    return std::min(stored_max * kMaximaMargin, std::numeric_limits<float>::max());
}

float value_scale(Storage storage, float max_value)
{
    switch (storage) {
    case Storage::r16f:
        return half_value_scale(max_value);
    case Storage::r8:
        return max_value > 0 ? max_value : 1;
    default:
        return 1;
    }
}

int max_slots_per_axis(const Limits& limits)
{
    return std::min(kMostSlotsPerAxis, limits.max_texture_3d / kAtlasBrickDim);
}

/// Bricks along x, y and z of an atlas with room for `slots`: the least unused room, then the most
/// nearly a cube, with no edge under half or over four times the cube's.
glm::ivec3 atlas_bricks(std::uint64_t slots, int max_per_axis)
{
    const auto count = static_cast<std::int64_t>(slots);
    std::int64_t cube = 0;
    while (cube * cube * cube < count)
        ++cube;
    assert(cube <= max_per_axis);

    glm::i64vec3 best{cube};
    for (std::int64_t z = std::max<std::int64_t>(1, cube / 2); z <= cube; ++z) {
        for (std::int64_t y = z; y == z || (y - 1) * (y - 1) * z < count; ++y) {
            const std::int64_t x = (count + y * z - 1) / (y * z);
            if (x > max_per_axis || y > max_per_axis)
                continue;
            const std::int64_t room = x * y * z, best_room = best.x * best.y * best.z;
            if (room < best_room || (room == best_room && x + y + z < best.x + best.y + best.z))
                best = {x, y, z};
        }
    }
    return best;
}

/// 31 bits of a float >= 0, rounded.
std::uint32_t constant_page(float stored)
{
    return shared::constant_page(std::bit_cast<std::uint32_t>(stored));
}

std::uint32_t brick_page(const glm::ivec3& slot, int scale_step)
{
    const glm::uvec3 s(slot);
    return shared::brick_page(s.x, s.y, s.z, static_cast<std::uint32_t>(scale_step));
}

glm::ivec3 slot_of(std::uint32_t page)
{
    return {shared::page_slot_x(page), shared::page_slot_y(page), shared::page_slot_z(page)};
}

/// Of the least scale that is not under `ratio`, 0..1 of the largest.
int scale_step(float ratio)
{
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(std::min(ratio, 1.0f));
    return std::min(static_cast<int>(shared::scale_step_above(bits)), kScaleSteps);
}

float scale_of(std::uint32_t page)
{
    return std::bit_cast<float>(shared::page_scale_bits(page));
}

std::string bytes_text(double bytes)
{
    constexpr std::array<const char*, 7> kUnits{"bytes", "KiB", "MiB", "GiB", "TiB", "PiB", "EiB"};
    std::size_t unit = 0;
    for (; bytes >= 1024 && unit + 1 < kUnits.size(); ++unit)
        bytes /= 1024;
    return fmt::format("{:.{}f} {}", bytes, unit == 0 ? 0 : 1, kUnits[unit]);
}

/// The two layouts of a grid weighed against the limits.
struct Choice {
    double dense_bytes = 0, brick_bytes = 0;
    bool dense_fits = false, bricks_fit = false;
    bool bricks_counted = false;  ///< else brick_bytes is the page table alone
};

[[noreturn]] void refuse(const VoxelGrid& grid, Layout asked, const Choice& choice,
                         const Limits& limits)
{
    const glm::i64vec3 size =
        glm::i64vec3(grid.index_max) - glm::i64vec3(grid.index_min) + std::int64_t{1};
    const std::string dense = bytes_text(choice.dense_bytes) + " dense";
    const std::string bricks =
        (choice.bricks_counted ? "" : "more than ") + bytes_text(choice.brick_bytes) + " as bricks";
    std::string remedy;
    if (asked == Layout::dense && choice.bricks_fit)
        remedy = "lay it out as bricks, ";
    if (asked == Layout::bricks && choice.dense_fits)
        remedy = "lay it out dense, ";
    throw Error(fmt::format(
        "{}: {} x {} x {} voxels take {}, over the limit of {} and {} texels along an edge; {}"
        "resample the grid coarser, cut it into several media, or store it in fewer bits",
        grid.name.empty() ? "grid" : grid.name, size.x, size.y, size.z,
        asked == Layout::dense    ? dense
        : asked == Layout::bricks ? bricks
                                  : dense + " and " + bricks,
        bytes_text(static_cast<double>(limits.max_bytes)), limits.max_texture_3d, remedy));
}

/// What becomes of the grid as bytes: of `count` cells, of which read(i, cell) fills in those that
/// count; each with its own scale, or all with one.
template <class Read>
ByteError byte_error(const VoxelGrid& grid, bool one_scale, std::size_t count, const Read& read)
{
    const Encoder encoder(Storage::r8, grid.channels, value_scale(Storage::r8, grid.max_value));
    // Deterministic: the same grid always gets the same storage.
    const ByteSums sums = tbb::parallel_deterministic_reduce(
        tbb::blocked_range<std::size_t>(0, count, 64), ByteSums{},
        [&](const auto& range, ByteSums sum) {
            Cell cell;
            for (std::size_t i = range.begin(); i != range.end(); ++i) {
                if (!read(i, cell))
                    continue;
                if (cell.uniform)
                    spread(cell, grid.channels);
                const float scale =
                    one_scale ? 1 : brick_scale(scale_step(cell.max / grid.max_value));
                sum = sum + encoder.of_brick(scale).byte_sums(cell.values.data(), kCellVoxels,
                                                              double{scale});
            }
            return sum;
        },
        std::plus<>());
    if (sums.values == 0)
        return {};  // constants alone
    return {std::sqrt(sums.error2 / sums.value2), sums.relative / sums.values};
}

/// All of a layout but its texels.
struct Draft {
    GridLayout layout;
    Encoder encoder;
    std::optional<CellReader> cells;      ///< nothing for a tree, whose leaves know what they are
    std::vector<std::uint32_t> leaves{};  ///< the pages of a tree's
};

/// Sets what follows from the storage: of a layout, and the encoder.
void set_storage(Draft& made, const VoxelGrid& grid, Storage storage, bool is_automatic,
                 const std::optional<ByteError>& error)
{
    GridLayout& layout = made.layout;
    layout.storage = storage;
    layout.storage_reason = is_automatic ? automatic_reason(storage, error) : "asked for";
    layout.value_scale = value_scale(storage, grid.max_value);
    made.encoder = Encoder(storage, grid.channels, layout.value_scale);
}

/// The page of a brick whose largest value is `most`, which becomes a bound of what is fetched.
std::uint32_t finish_brick(const Draft& made, std::size_t slot, const glm::ivec3& atlas,
                           float& most)
{
    const int step =
        made.layout.storage == Storage::r8 ? scale_step(most / made.layout.value_scale) : 0;
    most = bound(made.encoder.of_brick(brick_scale(step)).decoded(most));
    return brick_page(unlinear(slot, atlas), step);
}

/// Likewise of a constant.
std::uint32_t finish_constant(const Draft& made, float& value)
{
    const float stored = made.encoder.constant(value);
    value = bound(stored * made.layout.value_scale);
    return constant_page(stored);
}

/// Whether a page table would be large and have next to nothing in it, or too long: then it is a
/// tree, whose fetches depend on each other, four or five in a row for a sample.
bool wants_tree(const VoxelGrid& grid, const Frame& frame, const Limits& limits)
{
    constexpr double kManyPages = 1 << 22;  // 16 MiB of them
    constexpr double kPagesPerBrick = 16;
    return std::max({frame.page_count.x, frame.page_count.y, frame.page_count.z}) >
               limits.max_texture_3d ||
           volume(frame.page_count) >
               std::max(kManyPages, kPagesPerBrick * static_cast<double>(grid.bricks.size()));
}

Draft draft_tree(const VoxelGrid& grid, const Frame& frame, Layout asked, Storage storage,
                 const Limits& limits, Choice choice)
{
    const bool is_automatic = storage == Storage::automatic;
    if (is_automatic)
        storage = float_storage(grid);
    Draft made{{}, {storage, grid.channels, 1}, std::nullopt};
    GridLayout& layout = made.layout;
    layout.layout = Layout::bricks;
    layout.channels = grid.channels == 3 ? 4 : 1;
    layout.field_min = frame.field_min;
    layout.field_max = frame.field_max;
    layout.origin = layout.maxima_origin = frame.first_page * std::int64_t{kBrickDim};
    std::optional<PageTree> tree = make_page_tree(
        grid, frame.first_page,
        std::max({frame.page_count.x, frame.page_count.y, frame.page_count.z}), limits.max_bytes);
    choice.brick_bytes = static_cast<double>(limits.max_bytes);
    if (!tree)
        refuse(grid, asked, choice, limits);
    layout.tree = std::move(*tree);
    std::vector<PageTree::Leaf>& leaves = layout.tree.leaves;
    std::vector<PageTree::Node>& nodes = layout.tree.nodes;

    const auto cube = [](double edge) { return edge * edge * edge; };
    const int most_bricks = max_slots_per_axis(limits);
    const int most_nodes = std::min(kMostSlotsPerAxis, limits.max_texture_3d / PageTree::kNodeDim);
    choice.bricks_counted = true;
    const bool named = static_cast<double>(leaves.size()) <= cube(most_bricks) &&
                       static_cast<double>(nodes.size()) <= cube(most_nodes);
    glm::ivec3 atlas{0}, node_atlas{0};
    if (named) {
        atlas = atlas_bricks(leaves.size(), most_bricks);
        node_atlas = atlas_bricks(nodes.size(), most_nodes);
    }
    std::optional<ByteError> error;
    if (is_automatic && storage == Storage::r16f) {
        error = byte_error(grid, false, leaves.size(), [&](std::size_t i, Cell& cell) {
            read_cell(grid, leaves[i].sources, cell);
            return true;
        });
        if (error->is_small())
            storage = Storage::r8;
    }
    set_storage(made, grid, storage, is_automatic, error);
    layout.texture_size = atlas * kAtlasBrickDim;
    layout.page_count = node_atlas * PageTree::kNodeDim;
    choice.brick_bytes = static_cast<double>(layout.gpu_bytes());
    if (!named || choice.brick_bytes > static_cast<double>(limits.max_bytes))
        refuse(grid, asked, choice, limits);

    std::vector<std::uint32_t> constants;
    for (std::size_t i = 0; i < leaves.size(); ++i)
        made.leaves.push_back(finish_brick(made, i, atlas, leaves[i].most));
    for (float& value : layout.tree.constants)
        constants.push_back(finish_constant(made, value));
    layout.tree.sum_up();
    // The root, which is the last node, comes first.
    const auto place_of = [&](std::size_t node) {
        return unlinear(nodes.size() - 1 - node, node_atlas);
    };
    layout.pages.resize(volume(layout.page_count));
    for (std::size_t n = 0; n < nodes.size(); ++n) {
        const glm::ivec3 corner = place_of(n) * PageTree::kNodeDim;
        for (int i = 0; i < PageTree::kNodeEntries; ++i) {
            const PageTree::Entry entry = nodes[n].entries[static_cast<std::size_t>(i)];
            const auto at = static_cast<std::size_t>(std::abs(entry) - 1);
            layout
                .pages[linear(corner + glm::ivec3(i & 7, i >> 3 & 7, i >> 6), layout.page_count)] =
                entry == 0           ? 0
                : entry < 0          ? constants[at]
                : nodes[n].level > 1 ? brick_page(place_of(at), 0)
                                     : made.leaves[at];
        }
    }
    return made;
}

Draft draft(const VoxelGrid& grid, Layout asked, Storage storage, const Limits& limits)
{
    const Frame frame(grid);
    const bool is_automatic = storage == Storage::automatic;
    if (is_automatic)
        storage = float_storage(grid);
    const auto max_bytes = static_cast<double>(limits.max_bytes);
    const auto edges_fit = [&](const glm::i64vec3& size) {
        return glm::all(glm::lessThanEqual(size, glm::i64vec3(limits.max_texture_3d)));
    };
    const auto texel_bytes = [&](Storage s) {
        return static_cast<double>(Encoder(s, grid.channels, 1).texel_bytes());
    };
    const double page_bytes = sizeof(std::uint32_t) * volume(frame.page_count);

    Choice choice;
    choice.dense_bytes = texel_bytes(storage) * volume(frame.dense_size);
    choice.dense_fits = edges_fit(frame.dense_size) && choice.dense_bytes <= max_bytes;
    choice.brick_bytes = page_bytes;
    choice.bricks_fit = edges_fit(frame.page_count) && choice.brick_bytes <= max_bytes;

    if (asked != Layout::dense && wants_tree(grid, frame, limits))
        return draft_tree(grid, frame, asked, is_automatic ? Storage::automatic : storage, limits,
                          choice);

    // Before anything is allocated. What follows takes 12 bytes a page on the CPU, at most three
    // times what was just found to fit.
    if (asked == Layout::dense
            ? !choice.dense_fits
            : !choice.bricks_fit && !(asked == Layout::automatic && choice.dense_fits))
        refuse(grid, asked, choice, limits);

    Draft made{{}, {storage, grid.channels, 1}, CellReader(grid, frame)};
    const CellReader& cells = *made.cells;
    GridLayout& layout = made.layout;
    layout.channels = grid.channels == 3 ? 4 : 1;
    layout.field_min = frame.field_min;
    layout.field_max = frame.field_max;
    layout.maxima_origin = frame.first_page * std::int64_t{kBrickDim};
    layout.maxima_count = frame.page_count;
    layout.page_count = frame.page_count;
    layout.maxima.resize(volume(layout.maxima_count));
    layout.extents.resize(volume(layout.maxima_count));
    layout.pages.resize(volume(layout.page_count));

    // Of the grid itself; what is stored of it is found once the storage is known.
    for_each_page(layout.page_count, [&](std::size_t i, const glm::ivec3& page, Cell& cell) {
        cells.read(page, cell);
        if (cell.max <= 0)
            return;  // empty already
        layout.maxima[i] = cell.max;
        layout.extents[i] = extent_of(cell, grid.channels);
        layout.pages[i] = cell.uniform && grid.channels == 1 ? 0 : kPageBrick;
    });

    const auto slots = static_cast<std::uint64_t>(
        std::count_if(layout.pages.begin(), layout.pages.end(), is_brick));
    const int max_per_axis = max_slots_per_axis(limits);
    glm::ivec3 atlas{0};
    choice.bricks_counted = true;
    if (const double most = max_per_axis; static_cast<double>(slots) <= most * most * most)
        atlas = atlas_bricks(slots, max_per_axis);
    else
        choice.bricks_fit = false;
    const double room = std::max(volume(glm::i64vec3(atlas)), static_cast<double>(slots));
    const auto brick_bytes = [&](Storage s) {
        return page_bytes + texel_bytes(s) * kCellVoxels * room;
    };
    const Storage floats = storage;
    const bool may_choose = asked == Layout::automatic && choice.bricks_fit && choice.dense_fits;
    bool is_dense = asked == Layout::dense ||  // which is faster, so few bytes are no reason
                    (asked == Layout::automatic && choice.dense_fits &&
                     (!choice.bricks_fit || choice.dense_bytes <= brick_bytes(floats)));
    std::optional<ByteError> error;
    const auto weigh_bytes = [&] {
        if (is_automatic && floats == Storage::r16f)
            error = byte_error(grid, is_dense, layout.pages.size(), [&](std::size_t i, Cell& cell) {
                if (is_dense ? layout.maxima[i] == 0 : !is_brick(layout.pages[i]))
                    return false;
                cells.read(unlinear(i, layout.page_count), cell);
                return true;
            });
        storage = error && error->is_small() ? Storage::r8 : floats;
    };
    weigh_bytes();
    if (is_automatic && is_dense && storage == Storage::r16f && may_choose &&
        brick_bytes(Storage::r8) <= kManyFewerBytes * choice.dense_bytes) {
        const std::optional<ByteError> dense_error = error;
        is_dense = false;
        weigh_bytes();
        if (storage != Storage::r8) {
            is_dense = true;
            error = dense_error;
        }
    }
    choice.brick_bytes = brick_bytes(storage);
    choice.bricks_fit = choice.bricks_fit && choice.brick_bytes <= max_bytes;
    if (!is_dense && !choice.bricks_fit) {
        if (asked == Layout::bricks || !choice.dense_fits)
            refuse(grid, asked, choice, limits);
        is_dense = true;
        weigh_bytes();
    }

    layout.layout = is_dense ? Layout::dense : Layout::bricks;
    set_storage(made, grid, storage, is_automatic, error);
    if (layout.layout == Layout::dense) {
        layout.origin = frame.field_min;
        layout.texture_size = frame.dense_size;
        layout.page_count = glm::ivec3{0};
        layout.pages.clear();
        for (float& most : layout.maxima)
            most = bound(made.encoder.decoded(most));
        return made;
    }
    layout.origin = layout.maxima_origin;
    layout.texture_size = atlas * kAtlasBrickDim;
    std::size_t slot = 0;
    for (std::size_t i = 0; i < layout.pages.size(); ++i) {
        std::uint32_t& page = layout.pages[i];
        page = is_brick(page) ? finish_brick(made, slot++, atlas, layout.maxima[i])
                              : finish_constant(made, layout.maxima[i]);
    }
    return made;
}

void fill_dense(const VoxelGrid& grid, const Encoder& encoder, GridLayout& layout)
{
    // Rows of one brick's width, cut to the texture: zeros may lie outside the field's bounds.
    const auto write_brick = [&](const glm::ivec3& brick, const float* values, bool constant) {
        const glm::ivec3 at = brick * kBrickDim - layout.origin;
        const glm::ivec3 lo = glm::max(-at, glm::ivec3{0});
        const glm::ivec3 hi = glm::min(layout.texture_size - at, glm::ivec3{kBrickDim});
        for (int z = lo.z; z < hi.z && lo.x < hi.x; ++z) {
            for (int y = lo.y; y < hi.y; ++y) {
                const int voxel = constant ? 0 : (z * kBrickDim + y) * kBrickDim + lo.x;
                encoder.encode(values + voxel * grid.channels, hi.x - lo.x,
                               layout.texels.data() +
                                   encoder.texel_bytes() *
                                       linear(at + glm::ivec3{lo.x, y, z}, layout.texture_size));
            }
        }
    };
    const auto values_per_brick =
        static_cast<std::size_t>(VoxelGrid::kBrickVoxels) * static_cast<std::size_t>(grid.channels);
    tbb::parallel_for(std::size_t{0}, grid.bricks.size(), [&](std::size_t i) {
        write_brick(grid.bricks[i], grid.values.data() + i * values_per_brick, false);
    });

    const glm::ivec3 first = layout.maxima_origin / kBrickDim;
    const glm::ivec3 last = first + layout.maxima_count - 1;
    for (const VoxelTile& tile : grid.tiles) {
        std::array<float, std::size_t{3} * kBrickDim> row;
        for (std::size_t i = 0; i < row.size(); ++i)
            row[i] = tile.value[grid.channels == 1 ? 0 : static_cast<int>(i % 3)];
        const glm::ivec3 lo = glm::max(tile.brick_min, first), hi = glm::min(tile.brick_max, last);
        tbb::parallel_for(lo.z, hi.z + 1, [&](int z) {
            for (int y = lo.y; y <= hi.y; ++y)
                for (int x = lo.x; x <= hi.x; ++x)
                    write_brick({x, y, z}, row.data(), true);
        });
    }
}

/// Writes a brick at its slot and in its scale, which its page has.
void fill_brick(const Encoder& encoder, std::uint32_t page, int channels, Cell& cell,
                GridLayout& layout)
{
    const std::size_t texel_bytes = encoder.texel_bytes();
    const std::size_t row_bytes = texel_bytes * kAtlasBrickDim;
    if (cell.uniform)
        spread(cell, channels);
    std::array<std::uint8_t, std::size_t{4} * sizeof(float) * kCellVoxels> texels;
    encoder.of_brick(scale_of(page)).encode(cell.values.data(), kCellVoxels, texels.data());
    const glm::ivec3 at = slot_of(page) * kAtlasBrickDim;
    const std::uint8_t* from = texels.data();
    for (int z = 0; z < kAtlasBrickDim; ++z)
        for (int y = 0; y < kAtlasBrickDim; ++y, from += row_bytes)
            std::memcpy(layout.texels.data() +
                            texel_bytes * linear(at + glm::ivec3{0, y, z}, layout.texture_size),
                        from, row_bytes);
}

void fill_atlas(const VoxelGrid& grid, const CellReader& cells, const Encoder& encoder,
                GridLayout& layout)
{
    for_each_page(layout.page_count, [&](std::size_t i, const glm::ivec3& page, Cell& cell) {
        if (!is_brick(layout.pages[i]))
            return;
        cells.read(page, cell);
        fill_brick(encoder, layout.pages[i], grid.channels, cell, layout);
    });
}

void fill_leaves(const VoxelGrid& grid, const std::vector<std::uint32_t>& pages,
                 const Encoder& encoder, GridLayout& layout)
{
    tbb::parallel_for(std::size_t{0}, pages.size(), [&](std::size_t i) {
        Cell cell;
        read_cell(grid, layout.tree.leaves[i].sources, cell);
        fill_brick(encoder, pages[i], grid.channels, cell, layout);
    });
}

}  // namespace

float brick_scale(int step)
{
    return std::bit_cast<float>(shared::scale_step_bits(static_cast<std::uint32_t>(step)));
}

bool ByteError::is_small() const
{
    return rms <= kSmallRms && mean <= kSmallMean;
}

std::string_view storage_name(Storage storage)
{
    return storage == Storage::r32f ? "R32F" : storage == Storage::r16f ? "R16F" : "R8";
}

std::uint64_t GridLayout::gpu_bytes() const
{
    const std::size_t texel_bytes = bytes_per_value(storage) * static_cast<std::size_t>(channels);
    return texel_bytes * volume(texture_size) + sizeof(std::uint32_t) * volume(page_count);
}

GridLayout plan_layout(const VoxelGrid& grid, Layout layout, Storage storage, const Limits& limits)
{
    if (grid.empty())
        return {};
    GridLayout plan = draft(grid, layout, storage, limits).layout;
    plan.pages = {};
    plan.maxima = {};
    plan.extents = {};
    plan.tree.nodes = {};
    plan.tree.leaves = {};
    plan.tree.constants = {};
    return plan;
}

GridLayout make_layout(const VoxelGrid& grid, Layout layout, Storage storage, const Limits& limits)
{
    if (grid.empty())
        return {};
    Draft made = draft(grid, layout, storage, limits);
    GridLayout& result = made.layout;
    result.texels.resize(made.encoder.texel_bytes() * volume(result.texture_size));
    if (result.layout == Layout::dense)
        fill_dense(grid, made.encoder, result);
    else if (result.tree.levels > 0)
        fill_leaves(grid, made.leaves, made.encoder, result);
    else
        fill_atlas(grid, *made.cells, made.encoder, result);
    return std::move(result);
}

}  // namespace fumarole::medium
