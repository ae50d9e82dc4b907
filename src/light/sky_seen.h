#pragma once

#include <optional>
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

/// The last answer, which stays for the same surfaces and number of media: media that move or
/// change leave it as it is, so that frames of a sequence have one.
class LastSkySeen {
public:
    const SkySeen& of(const Scene& scene, const Bounds& media);
    [[nodiscard]] const SkySeen& last() const { return last_; }

private:
    struct Key {
        std::vector<Surface> surfaces;
        std::size_t media = 0;
        bool operator==(const Key&) const = default;
    };
    std::optional<Key> key_;
    SkySeen last_;
};

}  // namespace fumarole::light
