#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include <fumarole/export.h>
#include <fumarole/voxel_grid.h>

// OpenVDB files to CPU data. The only place that includes OpenVDB.

namespace fumarole::asset {

/// What a file says of one grid, with its values measured.
struct GridInfo {
    std::string name;        ///< unique address within the file: `density`, or `density[1]`
    std::string value_type;  ///< `float`, `half`, `double`, `vec3s`, ..., as OpenVDB names them
    std::string grid_class;  ///< `fog volume`, `level set`, `staggered`, `unknown`
    std::string transform;   ///< OpenVDB's map type, e.g. `AffineMap`
    glm::dmat4 world_from_index{1.0};
    glm::dvec3 voxel_size{1.0};             ///< metres
    glm::ivec3 index_min{1}, index_max{0};  ///< active bounds, inclusive; min > max when empty
    glm::dvec3 world_min{0}, world_max{0};  ///< metres, the active voxels with their half-voxel rim
    std::uint64_t active_voxels = 0;
    std::uint64_t leaf_bricks = 0;
    std::uint64_t active_tiles = 0;
    double min = 0, max = 0, mean = 0;  ///< min, max and mean of active values (vec3: of lengths)
    std::uint64_t nan_count = 0, inf_count = 0, negative_count = 0;
    glm::dvec3 mean_vector{0};  ///< mean vector of active values of a vec3 grid
    std::string refusal;        ///< "" if load_grid takes it, else the reason in one line
};

struct VdbInfo {
    std::filesystem::path file;
    std::uint64_t file_bytes = 0;
    std::string creator;  ///< creator of the file's metadata, or ""
    std::vector<GridInfo> grids;
};

/// A grid and what was said while it was read (each a line for the user: NaN counts, a level set
/// made into fog, ...).
struct LoadedGrid {
    VoxelGrid grid;
    std::vector<std::string> notes;
};

/// Reads all grids of a file to describe them.
/// @throws Error naming the file: not there, no VDB, damaged, cut short.
FUMAROLE_API VdbInfo inspect_vdb(const std::filesystem::path& file);

/// What a file says of its grids, without reading their values: bounds and counts are those that
/// stand beside them, min and mean are 0, and max is infinite where there are voxels. Where nothing
/// stands there it is inspect_vdb.
/// @throws Error as inspect_vdb does, as far as it looks.
FUMAROLE_API VdbInfo read_vdb_headers(const std::filesystem::path& file);

/// Whether load_grid finds a grid of that name.
FUMAROLE_API bool has_grid(const VdbInfo& file, const std::string& name);

/// Active voxels of the grid that load_grid finds, or of all that are taken for fog if the name is
/// ""; 0 where there is none.
FUMAROLE_API std::uint64_t voxels_in(const VdbInfo& file, const std::string& name);

/// Which of a file's grids load_grid("") tries, the likeliest first (grid_names.h has the order).
FUMAROLE_API std::vector<const GridInfo*> fog_candidates(const VdbInfo& file);

/// Reads one grid: `name`, `name[n]`, or "" for the one that looks most like smoke (grid_names.h).
/// Case counts only where it tells two apart. Float, half, double and vec3 (of float or double); a
/// level set becomes fog. NaN and infinities become 0 and are counted in a note; negatives are
/// clamped to 0 and counted. A `name` that is not there while name.x, name.y and name.z are (or
/// name_r, name_g and name_b, ...) becomes one vec3 grid.
/// @throws Error naming the file and what it has: no such grid; point, bool, int or mask grids; a
/// frustum transform; a transform that can't be inverted; bounds too large to address.
FUMAROLE_API LoadedGrid load_grid(const std::filesystem::path& file, const std::string& name);

/// Reads a grid of vectors, as load_grid does but for the signs, which stay: a velocity. Its
/// max_value is the largest size of a component.
/// @throws Error as load_grid, and if it has one number a voxel
FUMAROLE_API LoadedGrid load_vectors(const std::filesystem::path& file, const std::string& name);

}  // namespace fumarole::asset
