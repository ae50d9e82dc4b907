#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <fumarole/asset/scene_file.h>
#include <fumarole/asset/vdb_file.h>
#include <fumarole/export.h>

namespace fumarole::asset {

/// What a bare .vdb leaves open and the user may set.
struct AutoSceneOptions {
    std::string grid;  ///< "" for the first fog volume
    char up = 0;       ///< 'y', 'z', or 0: guessed from the file
    glm::uvec2 resolution{480, 270};
};

/// A scene for a bare .vdb: a camera that frames it, a key sun, a sky, a ground below it, and a
/// coefficient per density chosen from the grid's own statistics, so that the medium is neither
/// invisible nor a black lump whatever its voxel size and range. A grid called flame, fire, ...
/// makes it glow; without one temperature, heat, ... does, as a blackbody where it is hot enough.
/// One called Cd, color, rgb, albedo, ... colours it. The notes say
/// what was chosen and why, and which grids are not shown. A sequence (animation.h) has one scene
/// for all of its frames, whose grids are not read.
/// @throws Error as load_grid does; also if the grid is empty.
FUMAROLE_API LoadedScene make_auto_scene(const std::filesystem::path& vdb,
                                         const AutoSceneOptions& options);

/// The same for grids at hand, not empty; `emission` may be null. `up` is 'y' or 'z'. The medium's
/// file and grid names are left to the caller.
FUMAROLE_API LoadedScene frame_grids(std::shared_ptr<const VoxelGrid> density,
                                     std::shared_ptr<const VoxelGrid> emission, char up,
                                     glm::uvec2 resolution);

/// The coefficient that makes the average line of sight through a grid's content `opacity` opaque:
/// solves mean(1 - exp(-sigma_t * column)) = opacity over the columns along the index axes that
/// meet the content, column in metres times density. Columns under 1/100 of the mean column are
/// haze around the content and not counted. [1/m per unit of density]
FUMAROLE_API double sigma_t_for_opacity(const VoxelGrid& grid, double opacity);

/// The grid of a file that should glow beside `density`, or "".
FUMAROLE_API std::string guess_emission_grid(const VdbInfo& file, const std::string& density);

/// The grid of a file that holds temperatures beside `density` and no flame to tell what burns, or
/// "".
FUMAROLE_API std::string guess_temperature_grid(const VdbInfo& file, const std::string& density);

/// The grid of a file that should colour `density` (three numbers a voxel, or three grids of one),
/// or "".
FUMAROLE_API std::string guess_color_grid(const VdbInfo& file, const std::string& density);

struct UpGuess {
    char axis;        ///< 'y' or 'z'
    std::string why;  ///< reason, as a note has it
};

/// Which way is up: from who wrote the file, the names of its grids, where its velocity points, or
/// else the shape of the content.
/// @param size of the content's box in world axes, metres
FUMAROLE_API UpGuess guess_up(const VdbInfo& file, const glm::dvec3& size);

}  // namespace fumarole::asset
