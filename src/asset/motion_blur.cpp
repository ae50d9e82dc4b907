#include "asset/motion_blur.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <tbb/parallel_for.h>

#include <fumarole/asset/load_limits.h>
#include <fumarole/errors.h>

namespace fumarole::asset {

namespace {

constexpr int kDim = VoxelGrid::kBrickDim;
constexpr std::size_t kVoxels = VoxelGrid::kBrickVoxels;
constexpr double kMostVoxels = 256;

bool by_zyx(const glm::ivec3& a, const glm::ivec3& b)
{
    return std::array{a.z, a.y, a.x} < std::array{b.z, b.y, b.x};
}

/// All bricks that a grid has values in, those of its tiles too.
std::vector<glm::ivec3> all_bricks(const VoxelGrid& grid)
{
    std::vector<glm::ivec3> bricks = grid.bricks;
    for (const VoxelTile& tile : grid.tiles)
        for (int z = tile.brick_min.z; z <= tile.brick_max.z; ++z)
            for (int y = tile.brick_min.y; y <= tile.brick_max.y; ++y)
                for (int x = tile.brick_min.x; x <= tile.brick_max.x; ++x)
                    bricks.emplace_back(x, y, z);
    return bricks;
}

std::uint64_t bricks_in(const VoxelGrid& grid)
{
    std::uint64_t count = grid.bricks.size();
    for (const VoxelTile& tile : grid.tiles) {
        const glm::dvec3 size = glm::dvec3(tile.brick_max) - glm::dvec3(tile.brick_min) + 1.0;
        count += static_cast<std::uint64_t>(std::min(size.x * size.y * size.z, 1e15));
    }
    return count;
}

/// Spreads a grid's values over the voxels that each passes. Sums are kept as whole numbers, whose
/// order of addition does not matter: the result is the same bits for any number of threads.
class Spreader {
public:
    Spreader(const VoxelGrid& grid, const Displacement& displacement, int channels,
             const std::filesystem::path& file)
        : grid_(grid), values_(grid), velocity_(*displacement.velocity), channels_(channels),
          file_(file)
    {
        const glm::dmat4 index_from_world = glm::inverse(grid.world_from_index);
        index_from_value_ = glm::dmat3(index_from_world) * displacement.world_from_value;
        velocity_from_index_ =
            glm::inverse(displacement.velocity->world_from_index) * grid.world_from_index;
        check_memory(file, bricks_in(grid) * kVoxels * sizeof(std::int64_t) *
                               static_cast<std::size_t>(channels));
        sources_ = all_bricks(grid);
        find_targets();
    }

    /// @param parts of a voxel, by its value and index: what is spread, one number a channel
    template <class Parts> void spread(double most, const Parts& parts)
    {
        unit_ = most > 0 ? most / double(1ull << 40) : 1;
        sums_.assign(targets_.size() * kVoxels * static_cast<std::size_t>(channels_), 0);
        tbb::parallel_for(std::size_t(0), sources_.size(), [&](std::size_t i) {
            for_each_voxel(sources_[i], [&](glm::ivec3 index, glm::vec3 value) {
                add(index, parts(value, index));
            });
        });
    }

    /// @param value of a voxel's sums, one a channel
    template <class Value> VoxelGrid result(const Value& value) const
    {
        VoxelGrid out;
        out.name = grid_.name;
        out.channels = grid_.channels;
        out.world_from_index = grid_.world_from_index;
        const auto channels = static_cast<std::size_t>(channels_);
        const auto kept = static_cast<std::size_t>(out.channels);
        glm::ivec3 lo(std::numeric_limits<int>::max()), hi(std::numeric_limits<int>::min());
        std::vector<float> brick(kVoxels * kept);
        for (std::size_t b = 0; b < targets_.size(); ++b) {
            bool any = false;
            for (std::size_t v = 0; v < kVoxels; ++v) {
                glm::dvec4 sums(0);
                for (std::size_t c = 0; c < channels; ++c)
                    sums[static_cast<int>(c)] =
                        unit_ * static_cast<double>(sums_[(b * kVoxels + v) * channels + c]);
                const glm::vec3 all = value(sums);
                bool here = false;
                for (std::size_t c = 0; c < kept; ++c) {
                    brick[v * kept + c] = all[static_cast<int>(c)];
                    out.max_value = std::max(out.max_value, all[static_cast<int>(c)]);
                    here = here || all[static_cast<int>(c)] > 0;
                }
                if (!here)
                    continue;
                any = true;
                ++out.active_voxels;
                const int i = static_cast<int>(v);
                const glm::ivec3 index =
                    targets_[b] * kDim + glm::ivec3(i % kDim, i / kDim % kDim, i / kDim / kDim);
                lo = glm::min(lo, index);
                hi = glm::max(hi, index);
            }
            if (!any)
                continue;
            out.bricks.push_back(targets_[b]);
            out.values.insert(out.values.end(), brick.begin(), brick.end());
        }
        if (!out.bricks.empty()) {
            out.index_min = lo;
            out.index_max = hi;
        }
        return out;
    }

private:
    template <class Visit> void for_each_voxel(glm::ivec3 brick, const Visit& visit) const
    {
        for (int z = 0; z < kDim; ++z)
            for (int y = 0; y < kDim; ++y)
                for (int x = 0; x < kDim; ++x) {
                    const glm::ivec3 index = brick * kDim + glm::ivec3(x, y, z);
                    if (const glm::vec3 value = values_.value(index); value != glm::vec3(0))
                        visit(index, value);
                }
    }

    /// In voxels, over the whole shutter.
    [[nodiscard]] glm::dvec3 way(glm::ivec3 index) const
    {
        const glm::dvec3 at(velocity_from_index_ * glm::dvec4(glm::dvec3(index), 1));
        return index_from_value_ * velocity_.sample(at);
    }

    void find_targets()
    {
        struct Reach {
            glm::ivec3 lo{0}, hi{-1};
            double longest = 0;
        };
        std::vector<Reach> reaches(sources_.size());
        tbb::parallel_for(std::size_t(0), sources_.size(), [&](std::size_t i) {
            glm::dvec3 lo(std::numeric_limits<double>::max()), hi(-lo);
            for_each_voxel(sources_[i], [&](glm::ivec3 index, glm::vec3) {
                const glm::dvec3 half = 0.5 * glm::abs(way(index));
                lo = glm::min(lo, glm::dvec3(index) - half);
                hi = glm::max(hi, glm::dvec3(index) + half + 1.0);
                reaches[i].longest = std::max(reaches[i].longest, 2 * glm::length(half));
            });
            if (lo.x <= hi.x && reaches[i].longest <= kMostVoxels) {
                reaches[i].lo = glm::ivec3(glm::floor(lo / double(kDim)));
                reaches[i].hi = glm::ivec3(glm::floor(hi / double(kDim)));
            }
        });
        for (const Reach& reach : reaches) {
            if (!(reach.longest <= kMostVoxels))
                throw Error(fmt::format(
                    "{}: grid '{}' moves by {:.3g} voxels while the shutter is open, and more than "
                    "{:g} are refused: check 'velocity_unit' and 'shutter'",
                    file_.string(), grid_.name, reach.longest, kMostVoxels));
            for (int z = reach.lo.z; z <= reach.hi.z; ++z)
                for (int y = reach.lo.y; y <= reach.hi.y; ++y)
                    for (int x = reach.lo.x; x <= reach.hi.x; ++x)
                        targets_.emplace_back(x, y, z);
        }
        std::ranges::sort(targets_, by_zyx);
        targets_.erase(std::unique(targets_.begin(), targets_.end()), targets_.end());
        check_memory(file_, targets_.size() * kVoxels * sizeof(std::int64_t) *
                                static_cast<std::size_t>(channels_));
        check_cancelled(file_);
    }

    void add(glm::ivec3 index, glm::dvec4 parts)
    {
        const glm::dvec3 moved = way(index);
        const double length = glm::length(moved);
        // Four a voxel: of a way of whole voxels along an axis the sum of tents is a ramp to 1 %.
        const int steps = length < 1e-3 ? 1 : static_cast<int>(std::ceil(4 * length)) + 1;
        for (int step = 0; step < steps; ++step) {
            const glm::dvec3 p = glm::dvec3(index) + moved * ((step + 0.5) / steps - 0.5);
            const glm::dvec3 base = glm::floor(p), t = p - base;
            for (int corner = 0; corner < 8; ++corner) {
                const glm::ivec3 at(corner & 1, corner >> 1 & 1, corner >> 2);
                const glm::dvec3 w = glm::mix(1.0 - t, t, glm::dvec3(at));
                const double weight = w.x * w.y * w.z / steps;
                if (weight > 0)
                    add_to(glm::ivec3(base) + at, weight * parts);
            }
        }
    }

    void add_to(glm::ivec3 index, glm::dvec4 parts)
    {
        const glm::ivec3 brick(index.x >> 3, index.y >> 3, index.z >> 3);
        const glm::ivec3 in = index & (kDim - 1);
        const auto target = std::ranges::lower_bound(targets_, brick, by_zyx);
        const std::size_t at = (static_cast<std::size_t>(target - targets_.begin()) * kVoxels +
                                static_cast<std::size_t>((in.z * kDim + in.y) * kDim + in.x)) *
                               static_cast<std::size_t>(channels_);
        for (int c = 0; c < channels_; ++c)
            std::atomic_ref(sums_[at + static_cast<std::size_t>(c)])
                .fetch_add(std::llround(parts[c] / unit_), std::memory_order_relaxed);
    }

    const VoxelGrid& grid_;
    VoxelLookup values_, velocity_;
    int channels_;
    const std::filesystem::path& file_;
    glm::dmat3 index_from_value_;
    glm::dmat4 velocity_from_index_;
    std::vector<glm::ivec3> sources_, targets_;  ///< targets by z, then y, then x
    std::vector<std::int64_t> sums_;
    double unit_ = 1;
};

}  // namespace

VoxelGrid moved_grid(const VoxelGrid& grid, const Displacement& displacement, Kept kept,
                     const std::filesystem::path& file)
{
    if (grid.empty())
        return grid;
    Spreader spreader(grid, displacement, grid.channels, file);
    const auto most = static_cast<double>(grid.max_value);
    if (kept == Kept::fourth) {
        spreader.spread(std::pow(most, 4), [](glm::dvec3 value, glm::ivec3) {
            return glm::dvec4(glm::pow(value, glm::dvec3(4)), 0);
        });
        return spreader.result([](glm::dvec4 sums) {
            return glm::vec3(glm::pow(glm::dvec3(sums), glm::dvec3(0.25)));
        });
    }
    spreader.spread(most, [](glm::dvec3 value, glm::ivec3) { return glm::dvec4(value, 0); });
    return spreader.result([](glm::dvec4 sums) { return glm::vec3(sums); });
}

VoxelGrid moved_color(const VoxelGrid& color, const VoxelGrid& density,
                      const Displacement& displacement, const std::filesystem::path& file)
{
    if (color.empty())
        return color;
    Spreader spreader(color, displacement, 4, file);
    const VoxelLookup densities(density);
    const glm::dmat4 density_from_color =
        glm::inverse(density.world_from_index) * color.world_from_index;
    const double most =
        std::max(1.0, double(color.max_value)) * std::max(1e-30, double(density.max_value));
    spreader.spread(most, [&](glm::dvec3 value, glm::ivec3 index) {
        const glm::dvec3 at(density_from_color * glm::dvec4(glm::dvec3(index), 1));
        const glm::dvec3 here = densities.sample(at);
        // A little where there is none, so that the color of a rim is not black.
        const double weight = 1e-6 * double(density.max_value) +
                              (density.channels == 1 ? here.x : (here.x + here.y + here.z) / 3);
        return glm::dvec4(weight * value, weight);
    });
    return spreader.result([](glm::dvec4 sums) {
        return sums.w > 0 ? glm::vec3(glm::dvec3(sums) / sums.w) : glm::vec3(0);
    });
}

}  // namespace fumarole::asset
