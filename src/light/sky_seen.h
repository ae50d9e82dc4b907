#pragma once

#include <string>
#include <vector>

#include <fumarole/bounds.h>
#include <fumarole/scene.h>

namespace fumarole::light {

/// Whether much of the sky is hidden from where media are, but not all: as under a roof with gaps.
struct SkySeen {
    bool in_parts = false;
    std::string why;  ///< empty: there are no surfaces or no media
};

/// @param media bounds of all of them: metres, world
SkySeen sky_seen(const std::vector<Surface>& surfaces, const Bounds& media);

/// What the answer stays for: media that move or change leave it as it is, so that frames of a
/// sequence have one.
struct SkySeenKey {
    std::vector<Surface> surfaces;
    std::size_t media = 0;  ///< number of them
    bool operator==(const SkySeenKey&) const = default;
};

}  // namespace fumarole::light
