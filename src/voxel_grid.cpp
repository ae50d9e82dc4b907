#include <fumarole/voxel_grid.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <fmt/format.h>

#include <fumarole/errors.h>

namespace fumarole {

namespace {

/// Largest table of bricks: 64 MiB, a box of 2048^3 voxels. Beyond it bricks are hashed, which
/// takes about three times as long a sample.
constexpr double kMaxTable = 1 << 24;

int in_brick(glm::ivec3 v)
{
    return v.x + VoxelGrid::kBrickDim * (v.y + VoxelGrid::kBrickDim * v.z);
}

glm::ivec3 brick_of(glm::ivec3 index)
{
    return {index.x >> 3, index.y >> 3, index.z >> 3};
}

glm::ivec3 voxel_of(glm::ivec3 index)
{
    return {index.x & 7, index.y & 7, index.z & 7};
}

}  // namespace

std::size_t VoxelLookup::Hash::operator()(const glm::ivec3& v) const noexcept
{
    // Bricks of neighbours must not share low bits only: an odd multiplier each, then one mix.
    std::uint64_t h = std::uint64_t(std::uint32_t(v.x)) * 0x9e3779b97f4a7c15u ^
                      std::uint64_t(std::uint32_t(v.y)) * 0xc2b2ae3d27d4eb4fu ^
                      std::uint64_t(std::uint32_t(v.z)) * 0x165667b19e3779f9u;
    h ^= h >> 32;
    return std::size_t(h);
}

VoxelGrid make_voxel_grid(std::span<const float> density, glm::ivec3 size,
                          const glm::dmat4& world_from_index)
{
    const auto at = [&](glm::ivec3 v) {
        return (static_cast<std::size_t>(v.z) * static_cast<std::size_t>(size.y) +
                static_cast<std::size_t>(v.y)) *
                   static_cast<std::size_t>(size.x) +
               static_cast<std::size_t>(v.x);
    };
    if (glm::any(glm::lessThan(size, glm::ivec3(1))) || density.size() != at({0, 0, size.z}))
        throw Error(fmt::format("a grid of {} x {} x {} voxels can't be made of {} densities; give "
                                "one for each voxel",
                                size.x, size.y, size.z, density.size()));
    VoxelGrid grid;
    grid.name = "density";
    grid.world_from_index = world_from_index;
    glm::ivec3 low(size), high(-1);
    const glm::ivec3 last_brick = brick_of(size - 1);
    for (glm::ivec3 b(0); b.z <= last_brick.z; ++b.z)
        for (b.y = 0; b.y <= last_brick.y; ++b.y)
            for (b.x = 0; b.x <= last_brick.x; ++b.x) {
                std::array<float, VoxelGrid::kBrickVoxels> values{};
                std::uint64_t filled = 0;
                for (int i = 0; i < VoxelGrid::kBrickVoxels; ++i) {
                    const glm::ivec3 v =
                        b * VoxelGrid::kBrickDim + glm::ivec3(i & 7, (i >> 3) & 7, i >> 6);
                    if (glm::any(glm::greaterThanEqual(v, size)))
                        continue;
                    const float value = density[at(v)];
                    if (!(value > 0 && std::isfinite(value)))
                        continue;
                    values.at(static_cast<std::size_t>(i)) = value;
                    low = glm::min(low, v);
                    high = glm::max(high, v);
                    grid.max_value = std::max(grid.max_value, value);
                    ++filled;
                }
                if (filled == 0)
                    continue;
                grid.active_voxels += filled;
                grid.bricks.push_back(b);
                grid.values.insert(grid.values.end(), values.begin(), values.end());
            }
    if (!grid.bricks.empty()) {
        grid.index_min = low;
        grid.index_max = high;
    }
    return grid;
}

VoxelLookup::VoxelLookup(const VoxelGrid& grid) : grid_(grid)
{
    assert(grid.values.size() ==
           grid.bricks.size() * VoxelGrid::kBrickVoxels * std::size_t(grid.channels));
    if (grid.bricks.empty() && grid.tiles.empty())
        return;
    brick_min_ = grid.bricks.empty() ? grid.tiles[0].brick_min : grid.bricks[0];
    brick_max_ = brick_min_;
    for (const glm::ivec3& brick : grid.bricks) {
        brick_min_ = glm::min(brick_min_, brick);
        brick_max_ = glm::max(brick_max_, brick);
    }
    for (const VoxelTile& tile : grid.tiles) {
        brick_min_ = glm::min(brick_min_, tile.brick_min);
        brick_max_ = glm::max(brick_max_, tile.brick_max);
    }

    const glm::dvec3 size = glm::dvec3(brick_max_) - glm::dvec3(brick_min_) + 1.0;
    if (size.x * size.y * size.z > kMaxTable) {
        bricks_.reserve(grid.bricks.size());
        for (std::size_t i = 0; i < grid.bricks.size(); ++i)
            bricks_.emplace(grid.bricks[i], int(i));
        return;
    }
    table_.assign(std::size_t(size.x * size.y * size.z), -1);
    const glm::ivec3 n(size);
    const auto at = [&](glm::ivec3 brick) -> int& {
        const glm::ivec3 b = brick - brick_min_;
        return table_[std::size_t(b.x + n.x * (b.y + n.y * b.z))];
    };
    for (std::size_t i = 0; i < grid.tiles.size(); ++i) {
        const VoxelTile& tile = grid.tiles[i];
        for (int z = tile.brick_min.z; z <= tile.brick_max.z; ++z)
            for (int y = tile.brick_min.y; y <= tile.brick_max.y; ++y)
                for (int x = tile.brick_min.x; x <= tile.brick_max.x; ++x)
                    at({x, y, z}) = -2 - int(i);
    }
    for (std::size_t i = 0; i < grid.bricks.size(); ++i)
        at(grid.bricks[i]) = int(i);
}

int VoxelLookup::entry(glm::ivec3 brick) const
{
    if (glm::any(glm::lessThan(brick, brick_min_)) || glm::any(glm::greaterThan(brick, brick_max_)))
        return -1;
    if (!table_.empty()) {
        const glm::ivec3 b = brick - brick_min_, n = brick_max_ - brick_min_ + 1;
        return table_[std::size_t(b.x + n.x * (b.y + n.y * b.z))];
    }
    if (const auto it = bricks_.find(brick); it != bricks_.end())
        return it->second;
    for (std::size_t i = 0; i < grid_.tiles.size(); ++i)
        if (glm::all(glm::lessThanEqual(grid_.tiles[i].brick_min, brick)) &&
            glm::all(glm::lessThanEqual(brick, grid_.tiles[i].brick_max)))
            return -2 - int(i);
    return -1;
}

glm::vec3 VoxelLookup::value(int entry, glm::ivec3 voxel_in_brick) const
{
    if (entry == -1)
        return glm::vec3(0);
    if (entry < -1) {
        const glm::vec3 tile = grid_.tiles[std::size_t(-2 - entry)].value;
        return grid_.channels == 1 ? glm::vec3(tile.x, 0, 0) : tile;
    }
    const std::size_t i =
        std::size_t(entry) * VoxelGrid::kBrickVoxels + std::size_t(in_brick(voxel_in_brick));
    if (grid_.channels == 1)
        return {grid_.values[i], 0, 0};
    return {grid_.values[3 * i], grid_.values[3 * i + 1], grid_.values[3 * i + 2]};
}

glm::vec3 VoxelLookup::value(glm::ivec3 index) const
{
    return value(entry(brick_of(index)), voxel_of(index));
}

glm::dvec3 VoxelLookup::sample(glm::dvec3 p_index) const
{
    // Also what keeps the conversion to int in range. Written so that NaN fails it.
    const glm::dvec3 lo = glm::dvec3(grid_.index_min) - 1.0, hi = glm::dvec3(grid_.index_max) + 1.0;
    if (grid_.empty() ||
        !(glm::all(glm::greaterThan(p_index, lo)) && glm::all(glm::lessThan(p_index, hi))))
        return glm::dvec3(0);

    const glm::dvec3 floor = glm::floor(p_index);
    const glm::dvec3 f = p_index - floor;
    const glm::ivec3 base(floor);
    const glm::ivec3 low = voxel_of(base);
    const glm::ivec3 low_brick = brick_of(base), high_brick = brick_of(base + 1);
    // Seven of eight cells along each axis lie in one brick, and one search finds all corners.
    const bool one_brick = low_brick == high_brick;
    const int first = entry(low_brick);
    if (one_brick && first < 0)
        return value(first, low);

    glm::dvec3 sum(0);
    for (int corner = 0; corner < 8; ++corner) {
        const glm::ivec3 step(corner & 1, corner >> 1 & 1, corner >> 2);
        const double weight =
            (step.x ? f.x : 1 - f.x) * (step.y ? f.y : 1 - f.y) * (step.z ? f.z : 1 - f.z);
        if (weight == 0)
            continue;
        const glm::ivec3 index = base + step;
        const int found = one_brick ? first : entry(brick_of(index));
        sum += weight * glm::dvec3(value(found, voxel_of(index)));
    }
    return sum;
}

}  // namespace fumarole
