#include "medium/grid_cells.h"

#include <algorithm>
#include <cstring>

namespace fumarole::medium {

namespace {

glm::vec3 constant(const VoxelGrid& grid, int source)
{
    return source == 0 ? glm::vec3{0} : grid.tiles[static_cast<std::size_t>(-source - 1)].value;
}

/// Copies the part of a cell that one of its 8 bricks covers.
void copy(const VoxelGrid& grid, int source, const glm::ivec3& offset, Cell& cell)
{
    const int channels = grid.channels;
    const glm::ivec3 lo = offset * VoxelGrid::kBrickDim;
    const glm::ivec3 size = glm::ivec3{VoxelGrid::kBrickDim} - offset * (VoxelGrid::kBrickDim - 1);
    for (int z = 0; z < size.z; ++z) {
        for (int y = 0; y < size.y; ++y) {
            float* to =
                cell.values.data() +
                channels * (((lo.z + z) * kAtlasBrickDim + lo.y + y) * kAtlasBrickDim + lo.x);
            if (source > 0) {
                const float* from =
                    grid.values.data() +
                    static_cast<std::size_t>(source - 1) * VoxelGrid::kBrickVoxels *
                        static_cast<std::size_t>(channels) +
                    channels * (z * VoxelGrid::kBrickDim + y) * VoxelGrid::kBrickDim;
                std::copy_n(from, size.x * channels, to);
            } else {
                const glm::vec3 value = constant(grid, source);
                for (int x = 0; x < size.x; ++x)
                    for (int c = 0; c < channels; ++c)
                        *to++ = value[c];
            }
        }
    }
}

}  // namespace

void spread(Cell& cell, int channels)
{
    for (int v = channels; v < kCellVoxels * channels; ++v)
        cell.values[v] = cell.values[v - channels];
}

PageExtent extent_of(const Cell& cell, int channels)
{
    constexpr int kLast = kAtlasBrickDim - 1;
    if (cell.uniform)
        return {glm::u8vec3(0), glm::u8vec3(kLast)};
    glm::ivec3 min(kLast), max(0);
    const float* value = cell.values.data();
    for (int z = 0; z <= kLast; ++z)
        for (int y = 0; y <= kLast; ++y)
            for (int x = 0; x <= kLast; ++x, value += channels) {
                if (std::all_of(value, value + channels, [](float v) { return v == 0; }))
                    continue;
                min = glm::min(min, glm::ivec3(x, y, z));
                max = glm::max(max, glm::ivec3(x, y, z));
            }
    return {glm::u8vec3(glm::max(min - 1, 0)), glm::u8vec3(glm::min(max + 1, kLast))};
}

glm::ivec3 corner_offset(int corner)
{
    return {corner & 1, corner >> 1 & 1, corner >> 2};
}

void read_cell(const VoxelGrid& grid, const CellSources& sources, Cell& cell)
{
    const bool one_constant =
        sources[0] <= 0 &&
        std::all_of(sources.begin(), sources.end(), [&](int s) { return s == sources[0]; });
    if (one_constant) {
        const glm::vec3 value = constant(grid, sources[0]);
        std::memcpy(cell.values.data(), &value, sizeof value);
        cell.uniform = true;
        cell.max = grid.channels == 1 ? value.x : std::max({value.x, value.y, value.z});
        return;
    }
    for (int corner = 0; corner < 8; ++corner)
        copy(grid, sources[static_cast<std::size_t>(corner)], corner_offset(corner), cell);

    const auto channels = static_cast<std::size_t>(grid.channels);
    const std::size_t count = kCellVoxels * channels;
    cell.uniform = true;
    for (std::size_t i = channels; i < count && cell.uniform; ++i)
        cell.uniform = cell.values[i] == cell.values[i - channels];
    // Four running maxima: one alone would wait on itself at each value.
    std::array<float, 4> most{};
    for (std::size_t i = 0; i < count; ++i)
        most[i % 4] = std::max(most[i % 4], cell.values[i]);
    cell.max = std::max({most[0], most[1], most[2], most[3]});
}

}  // namespace fumarole::medium
