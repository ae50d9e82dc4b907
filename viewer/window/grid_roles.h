#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "asset/medium_fit.h"
#include <fumarole/asset/vdb_file.h>
#include <fumarole/scene.h>

// What each grid of a .vdb is taken for, as a scene file says it: `grid`, `temperature_grid`,
// `emission_grid` and `color_grid` of a medium.

namespace fumarole::window {

enum class GridRole { off, density, temperature, emission, color };

/// All of them, in the order in which they are offered.
const std::vector<GridRole>& grid_roles();
std::string_view role_name(GridRole role);
/// All that a grid is taken for, in words: `density + emission`, or `off`.
std::string roles_text(const std::vector<GridRole>& roles);
/// @throws Error listing what there is
GridRole find_role(const std::string& name);

/// A grid of a file, as a list shows it. Three grids of one number that are a vector's components
/// (Cd.x, Cd.y, Cd.z) are one.
struct GridRow {
    std::string name;  ///< by which a scene file names it
    std::string type;  ///< `float`, `vec3s`, `3 x float`, with its class if that is known
    int channels = 1;  ///< numbers of a voxel, 1 or 3
    std::uint64_t voxels = 0;
    std::optional<std::pair<double, double>> range;  ///< of its values, or lengths, if known
    std::string refusal;                             ///< why it can be nothing but off, or ""
};

/// The grids of a file, in its order. @param measured whether the file's values were read too
std::vector<GridRow> grid_rows(const asset::VdbInfo& file, bool measured);

/// Why a grid can't be taken for something, or "".
std::string role_refusal(const GridRow& row, GridRole role);

/// The row of a grid that a scene names, whose case may be another.
std::optional<std::size_t> find_row(const std::vector<GridRow>& rows, const std::string& name);

/// Each part that a medium has, and the grid that is taken for it. A medium without extinction has
/// no density.
std::map<GridRole, std::string> parts_of(const GridMedium& medium);

/// What a medium takes a grid for: nothing, one thing, or two where a flame is its own smoke.
std::vector<GridRole> roles_of(const GridMedium& medium, const std::vector<GridRow>& rows,
                               std::size_t row);

/// The parts of a medium as they were when they were last on, by what multiplies them.
using RoleMemory = std::map<std::pair<GridRole, std::string>, GridMedium>;
void remember_parts(RoleMemory& memory, const GridMedium& medium);

/// A medium that takes its grids for other things.
struct RoutedMedium {
    GridMedium medium;    ///< what is not loaded yet is null
    asset::NewGrids fit;  ///< parts whose coefficients are yet to be chosen
};

/// Takes a grid for one thing alone, and no other grid for that. A part that `memory` knows comes
/// back as it was.
RoutedMedium with_role(GridMedium medium, const std::vector<GridRow>& rows, std::size_t row,
                       GridRole role, const RoleMemory& memory);

/// Takes over what `routed` takes its grids for, and what the parts that are new are multiplied by,
/// but for those that `memory` knows; all else stays.
void take_parts(GridMedium& medium, const GridMedium& routed, const RoleMemory& memory);

}  // namespace fumarole::window
