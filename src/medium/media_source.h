#pragma once

#include <string>
#include <vector>

// The scene's media as GLSL: written/media.glsl, a few functions for each medium and the sums over
// all. They read as if written by hand, so that a debugger and a compiler's message do.

namespace fumarole::medium {

/// A grid as its textures hold it.
struct GridSource {
    enum class Kind { dense, bricks, tree };
    Kind kind = Kind::dense;
    bool color = false;
};

/// One medium.
struct MediumSource {
    enum class Profile { grid, homogeneous, exp_height, noise };
    enum class Depth { none, closed, marched };  ///< how its optical depth is found

    Profile profile = Profile::grid;
    Depth depth = Depth::none;
    bool is_box = false;   ///< true if it is a box whose bounds are in metres
    bool islands = false;  ///< parts of it lie far apart, and are marched each for itself
    int density = -1;      ///< the grid it is read from; -1: none
    bool glows = false;    ///< true if it glows by `emission`, or where that is -1 by its density
    int emission = -1, tint = -1;
    int temperature = -1;  ///< the grid that it glows by as a blackbody
};

/// The text of written/media.glsl.
/// @param colored_extinction whether extinction_t is a vec3
std::string write_media(const std::vector<GridSource>& grids,
                        const std::vector<MediumSource>& media, bool colored_extinction);

}  // namespace fumarole::medium
