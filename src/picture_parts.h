#pragma once

#include <glm/glm.hpp>
#include <vector>

#include <fumarole/scene_renderer.h>
#include <fumarole/settings.h>

// A picture that is drawn part by part, none of which shows: each is drawn with a margin that the
// look-ups across its edges need, and begins where all that repeats over the picture (blue noise,
// texels, tiles of them, froxels) begins anew.

namespace fumarole {

/// What is drawn at once, and what is kept of it. Pixels, counted from the bottom left.
struct PicturePart {
    glm::ivec2 origin{0}, size{0};            ///< origin and size of the part in the whole picture
    glm::ivec2 keep_origin{0}, keep_size{0};  ///< origin and size of what is kept in what is drawn

    bool operator==(const PicturePart&) const = default;
};

/// @param settings settled for the whole picture
/// @param most_side of what is drawn at once; more where not even one margin would fit
/// @returns one part, without margins, where the region is the whole picture and small enough
std::vector<PicturePart> picture_parts(glm::ivec2 whole, const PictureRegion& region, int most_side,
                                       const FrameSettings& settings);

/// A projection of the whole picture, for a part of it.
glm::dmat4 clip_of_part(const glm::dmat4& clip_from_view, glm::ivec2 whole,
                        const PicturePart& part);

}  // namespace fumarole
