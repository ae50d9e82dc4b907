#include "window/grid_roles.h"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <set>

#include "asset/grid_names.h"
#include <fumarole/errors.h>

namespace fumarole::window {

namespace {

bool has_density(const GridMedium& medium)
{
    return medium.sigma_s_per_density + medium.sigma_a_per_density != glm::vec3(0);
}

/// All that a grid can be taken for.
constexpr std::array kParts{GridRole::density, GridRole::temperature, GridRole::emission,
                            GridRole::color};

/// The grid that is the density, which a scene may leave to the file.
std::string density_name(const GridMedium& medium)
{
    return medium.grid.empty() && medium.density ? medium.density->name : medium.grid;
}

std::string type_of(const asset::GridInfo& grid)
{
    return grid.grid_class.empty() || grid.grid_class == "unknown"
               ? grid.value_type
               : fmt::format("{}, {}", grid.value_type, grid.grid_class);
}

GridRow row_of(const asset::GridInfo& grid, bool measured)
{
    GridRow row{.name = grid.name,
                .type = type_of(grid),
                .channels = grid.value_type.starts_with("vec3") ? 3 : 1,
                .voxels = grid.active_voxels,
                .range = std::nullopt,
                .refusal = grid.refusal};
    if (measured && grid.active_voxels > 0 && grid.refusal.empty())
        row.range = {grid.min, grid.max};
    return row;
}

/// The name of the vector whose x or red a grid is, if the two others are there; or "".
std::string vector_of(const asset::GridInfo& grid, const std::vector<asset::GridName>& names)
{
    for (const std::string_view end : {".x", "_x", "x", ".r", "_r", "r"}) {
        if (!asset::lower_case(grid.name).ends_with(end) || grid.name.size() == end.size())
            continue;
        std::string whole = grid.name.substr(0, grid.name.size() - end.size());
        if (const auto channels = asset::find_channels(names, whole);
            channels && names[channels->front()].address == grid.name)
            return whole;
    }
    return "";
}

/// A part of a medium: the grid's name, and its voxels.
struct Part {
    std::string& grid;
    std::shared_ptr<const VoxelGrid>& voxels;
};

Part part_of(GridMedium& medium, GridRole role)
{
    switch (role) {
    case GridRole::temperature:
        return {medium.temperature_grid, medium.temperature};
    case GridRole::emission:
        return {medium.emission_grid, medium.emission};
    case GridRole::color:
        return {medium.color_grid, medium.color};
    default:
        return {medium.grid, medium.density};
    }
}

/// Gives a medium what `from` multiplies one of its parts by.
void take_coefficients(GridMedium& medium, const GridMedium& from, GridRole role)
{
    if (role == GridRole::density) {
        medium.sigma_s_per_density = from.sigma_s_per_density;
        medium.sigma_a_per_density = from.sigma_a_per_density;
    } else if (role == GridRole::temperature) {
        medium.temperature_scale = from.temperature_scale;
        medium.blackbody_intensity = from.blackbody_intensity;
        medium.blackbody_tint = from.blackbody_tint;
    } else if (role == GridRole::emission) {
        medium.emission_per_unit = from.emission_per_unit;
    }
}

/// Takes a part out of a medium. A density only loses its extinction: where the medium is, and
/// which file it is of, stays to be known.
void take_out(GridMedium& medium, GridRole role)
{
    GridMedium none;
    none.sigma_s_per_density = glm::vec3(0);
    take_coefficients(medium, none, role);
    if (role == GridRole::density)
        return;
    const Part part = part_of(medium, role);
    part.grid.clear();
    part.voxels = nullptr;
}

/// Has a part's coefficients chosen. A colour has none.
void ask_for(asset::NewGrids& fit, GridRole role)
{
    fit.density |= role == GridRole::density;
    fit.temperature |= role == GridRole::temperature;
    fit.emission |= role == GridRole::emission;
}

}  // namespace

const std::vector<GridRole>& grid_roles()
{
    static const std::vector<GridRole> roles{GridRole::off, GridRole::density,
                                             GridRole::temperature, GridRole::emission,
                                             GridRole::color};
    return roles;
}

std::string_view role_name(GridRole role)
{
    constexpr std::array<std::string_view, 5> kNames{"off", "density", "temperature", "emission",
                                                     "colour"};
    return kNames.at(static_cast<std::size_t>(role));
}

std::string roles_text(const std::vector<GridRole>& roles)
{
    std::string text;
    for (const GridRole role : roles)
        text += fmt::format("{}{}", text.empty() ? "" : " + ", role_name(role));
    return text.empty() ? std::string(role_name(GridRole::off)) : text;
}

GridRole find_role(const std::string& name)
{
    std::vector<std::string_view> names;
    for (const GridRole role : grid_roles()) {
        if (name == role_name(role))
            return role;
        names.push_back(role_name(role));
    }
    if (name == "color")
        return GridRole::color;
    throw Error(fmt::format("a grid can't be taken for '{}' (there are: {})", name,
                            fmt::join(names, ", ")));
}

std::vector<GridRow> grid_rows(const asset::VdbInfo& file, bool measured)
{
    std::vector<asset::GridName> names;
    for (const asset::GridInfo& grid : file.grids)
        names.push_back({grid.name, std::string(asset::without_number(grid.name))});
    std::map<std::string, std::string> vectors;  // by the name of their first component
    std::set<std::string> components;
    for (const asset::GridInfo& grid : file.grids) {
        const std::string whole = vector_of(grid, names);
        if (whole.empty())
            continue;
        const auto channels = asset::find_channels(names, whole);
        const bool alike = std::all_of(channels->begin(), channels->end(), [&](std::size_t c) {
            return !file.grids[c].value_type.starts_with("vec3") && file.grids[c].refusal.empty();
        });
        if (!alike)
            continue;
        vectors[grid.name] = whole;
        for (const std::size_t c : *channels)
            components.insert(file.grids[c].name);
    }
    std::vector<GridRow> rows;
    for (const asset::GridInfo& grid : file.grids) {
        GridRow row = row_of(grid, measured);
        if (const auto vector = vectors.find(grid.name); vector != vectors.end()) {
            row.name = vector->second;
            row.type = "3 x " + grid.value_type;
            row.channels = 3;
            row.range.reset();
        } else if (components.contains(grid.name)) {
            continue;
        }
        rows.push_back(std::move(row));
    }
    return rows;
}

std::string role_refusal(const GridRow& row, GridRole role)
{
    if (role == GridRole::off)
        return "";
    if (!row.refusal.empty())
        return row.refusal;
    if (row.voxels == 0)
        return "it is empty";
    if (role == GridRole::temperature && row.channels != 1)
        return "a temperature has one number a voxel, and this has three";
    if (role == GridRole::color && row.channels != 3)
        return "a colour has three numbers a voxel, and this has one";
    return "";
}

std::map<GridRole, std::string> parts_of(const GridMedium& medium)
{
    std::map<GridRole, std::string> parts;
    if (has_density(medium))
        parts[GridRole::density] = density_name(medium);
    for (const auto& [role, name] : {std::pair{GridRole::temperature, &medium.temperature_grid},
                                     std::pair{GridRole::emission, &medium.emission_grid},
                                     std::pair{GridRole::color, &medium.color_grid}})
        if (!name->empty())
            parts[role] = *name;
    return parts;
}

std::optional<std::size_t> find_row(const std::vector<GridRow>& rows, const std::string& name)
{
    std::vector<asset::GridName> names;
    names.reserve(rows.size());
    for (const GridRow& row : rows)
        names.push_back({row.name, std::string(asset::without_number(row.name))});
    return asset::find_name(names, name);
}

std::vector<GridRole> roles_of(const GridMedium& medium, const std::vector<GridRow>& rows,
                               std::size_t row)
{
    std::vector<GridRole> roles;
    for (const auto& [role, name] : parts_of(medium))
        if (find_row(rows, name) == row)
            roles.push_back(role);
    return roles;
}

void remember_parts(RoleMemory& memory, const GridMedium& medium)
{
    for (const auto& [role, name] : parts_of(medium))
        memory[{role, name}] = medium;
}

RoutedMedium with_role(GridMedium medium, const std::vector<GridRow>& rows, std::size_t row,
                       GridRole role, const RoleMemory& memory)
{
    const std::string& grid = rows.at(row).name;
    // From here on each part has the name that the list has.
    medium.grid = density_name(medium);
    for (const GridRole part : kParts) {
        std::string& name = part_of(medium, part).grid;
        if (const auto named = find_row(rows, name))
            name = rows[*named].name;
    }
    RoutedMedium routed{std::move(medium), {}};
    GridMedium& now = routed.medium;
    for (const auto& [part, name] : parts_of(now))
        if (part != role && name == grid)  // one grid is one thing
            take_out(now, part);
    const auto parts = parts_of(now);
    const auto there = parts.find(role);
    if (role == GridRole::off || (there != parts.end() && there->second == grid))
        return routed;
    // The colour and the albedo of another density are those of the one before it.
    const Part part = part_of(now, role);
    if (part.grid != grid)
        part.voxels = nullptr;
    part.grid = grid;
    if (const auto known = memory.find({role, grid}); known != memory.end()) {
        take_coefficients(now, known->second, role);
        return routed;
    }
    ask_for(routed.fit, role);
    if (role == GridRole::temperature)
        now.temperature_scale = 0;  // of another grid
    return routed;
}

void take_parts(GridMedium& medium, const GridMedium& routed, const RoleMemory& memory)
{
    const auto was = parts_of(medium), now = parts_of(routed);
    for (const GridRole role : kParts) {
        const auto a = was.find(role), b = now.find(role);
        if (b == now.end())
            take_out(medium, role);
        else if (a == was.end() || a->second != b->second) {
            const auto known = memory.find({role, b->second});
            take_coefficients(medium, known != memory.end() ? known->second : routed, role);
        }
    }
    GridMedium from = routed;
    for (const GridRole role : kParts) {
        const Part part = part_of(medium, role), other = part_of(from, role);
        part.grid = other.grid;
        part.voxels = other.voxels;
    }
}

}  // namespace fumarole::window
