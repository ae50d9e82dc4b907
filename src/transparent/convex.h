#pragma once

#include <fumarole/scene.h>

namespace fumarole::transparent {

/// Which way the triangles of a convex mesh wind, as seen from outside.
enum class Winding {
    none,  ///< it is flat or not convex, they wind both ways, or it takes long to tell
    counter_clockwise,
    clockwise,
};

/// Of a mesh all of which lies behind, or all before, each of its triangles: a ray meets two of
/// them at most, or as many at one depth.
Winding convex_winding(const Mesh& mesh);

}  // namespace fumarole::transparent
