#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

// What the names of a file's grids tell. Nobody agrees on their case.

namespace fumarole::asset {

/// How a grid is called.
struct GridName {
    std::string address;  ///< unique within its file: `density`, or `density[1]`
    std::string name;     ///< as its author called it
};

std::string lower_case(std::string_view text);

/// `density` of `density[1]`.
std::string_view without_number(std::string_view address);

/// How little a grid of single numbers looks like smoke: less is better. By its name density, then
/// smoke, soot, fog and cloud; then names that tell nothing, fog volumes before others before level
/// sets; at last what is known not to be smoke, as temperature, flame, shadow or distance.
int fog_rank(std::string_view name, std::string_view grid_class);

/// Whether it looks like smoke, or tells nothing: no temperature, flame, shadow, distance, ...
bool like_smoke(std::string_view name, std::string_view grid_class);

/// Which of the grids is meant: by its address, else by its name, else by either whatever the case.
std::optional<std::size_t> find_name(const std::vector<GridName>& grids, std::string_view wanted);

/// Three grids that are the channels of one called `wanted`: name.x, name_x or namex, and y, z; or
/// r, g, b.
std::optional<std::array<std::size_t, 3>> find_channels(const std::vector<GridName>& grids,
                                                        std::string_view wanted);

/// Names of a temperature, the likeliest first.
const std::vector<std::string_view>& temperature_names();

/// Names of a colour: Cd, color, rgb, albedo, ...
const std::vector<std::string_view>& color_names();

}  // namespace fumarole::asset
