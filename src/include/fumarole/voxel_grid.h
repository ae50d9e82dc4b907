#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include <fumarole/export.h>

namespace fumarole {

/// A constant region of a VoxelGrid, in whole bricks.
struct VoxelTile {
    glm::ivec3 brick_min;  ///< first brick, inclusive
    glm::ivec3 brick_max;  ///< last brick, inclusive
    glm::vec3 value;       ///< scalar grids use .x alone
};

/// A scalar or 3-vector field on an integer lattice, sparse: bricks of 8^3 values (the leaves of
/// OpenVDB), constant tiles, and 0 everywhere else. Values are finite and >= 0.
///
/// A voxel's centre is the transform of its integer index; between centres the field is trilinear,
/// so it reaches one voxel past the outermost values before it is 0.
struct VoxelGrid {
    static constexpr int kBrickDim = 8;
    static constexpr int kBrickVoxels = kBrickDim * kBrickDim * kBrickDim;

    std::string name;  ///< as the file addresses it: `density`, or `density[1]`
    int channels = 1;  ///< 1 or 3

    glm::dmat4 world_from_index{1.0};  ///< index to metres; any invertible affine map

    /// Brick b covers the voxels 8*b .. 8*b+7. Sorted by z, then y, then x; no brick twice, none
    /// inside a tile.
    std::vector<glm::ivec3> bricks;
    /// bricks.size() * 512 * channels numbers; in a brick x runs fastest, then y, then z; the
    /// channels of a voxel stand together.
    std::vector<float> values;
    std::vector<VoxelTile> tiles;

    /// Inclusive index bounds of all that is not 0. min > max when the grid is empty.
    glm::ivec3 index_min{1};
    glm::ivec3 index_max{0};

    std::uint64_t active_voxels = 0;  ///< as the file counts them, tiles included
    float max_value = 0;              ///< over all channels
    bool stored_as_half = false;      ///< the file holds 16-bit floats: no more precision is there

    [[nodiscard]] bool empty() const { return glm::any(glm::greaterThan(index_min, index_max)); }
};

/// A grid from densities in memory, x fastest, then y, then z; the first is the voxel of index 0.
/// Bricks of zeros alone are left out; negative values, NaN and infinities count as 0.
/// @param size voxels along each axis, > 0; `density` holds size.x * size.y * size.z of them
/// @throws Error if it does not
FUMAROLE_API VoxelGrid make_voxel_grid(std::span<const float> density, glm::ivec3 size,
                                       const glm::dmat4& world_from_index);

/// Random access to a VoxelGrid, built once: a table over the box of its bricks, or a hash of them
/// where that box is too large.
class FUMAROLE_API VoxelLookup {
public:
    explicit VoxelLookup(const VoxelGrid& grid);  ///< `grid` must outlive the lookup

    /// Value of one voxel; scalar grids answer in .x, with 0 in .yz.
    [[nodiscard]] glm::vec3 value(glm::ivec3 index) const;

    /// Trilinear, in double precision, at a point of index space. 0 far outside, and for NaN.
    [[nodiscard]] glm::dvec3 sample(glm::dvec3 p_index) const;

private:
    struct Hash {
        std::size_t operator()(const glm::ivec3& v) const noexcept;
    };

    /// >= 0: a brick, -1: nothing, <= -2: tile -2 - n.
    [[nodiscard]] int entry(glm::ivec3 brick) const;
    [[nodiscard]] glm::vec3 value(int entry, glm::ivec3 voxel_in_brick) const;

    const VoxelGrid& grid_;
    glm::ivec3 brick_min_{1}, brick_max_{0};  ///< box of all bricks and tiles
    std::vector<int> table_;                  ///< x fastest over that box; empty: bricks_ serves
    std::unordered_map<glm::ivec3, int, Hash> bricks_;
};

}  // namespace fumarole
