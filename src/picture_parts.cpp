#include "picture_parts.h"

#include <algorithm>

#include "shared/bindings.h"

namespace fumarole {

namespace {

/// One axis of a part.
struct Span {
    int begin = 0, end = 0;            ///< where the part that is drawn begins and ends
    int keep_begin = 0, keep_end = 0;  ///< both in the whole picture
};

struct Grid {
    int align = 1;   ///< pixels after which all that repeats begins anew
    int margin = 0;  ///< pixels that a look-up reaches at most
};

Grid grid_of(const FrameSettings& s)
{
    if (s.mode == FrameSettings::Mode::froxel)
        // Tricubic look-ups reach two columns; a part of one column would be all margin.
        return {s.tile * std::max(1, 32 / s.tile), 4 * s.tile};
    // The upsample reaches two texels, which the frame's offset moves by half a one, and a texel's
    // depth another.
    return {BLUE_NOISE_SIZE * s.resolution, 8 * s.resolution};
}

std::vector<Span> spans(int whole, int first, int length, int most, const Grid& grid)
{
    const auto drawn_from = [&](int begin) {
        return std::max(0, begin - grid.margin) / grid.align * grid.align;
    };
    std::vector<Span> found;
    const int end = first + length;
    for (int begin = first; begin < end;) {
        const int from = drawn_from(begin);
        int keep_end = std::min(end, from + most >= whole ? whole : from + most - grid.margin);
        keep_end = std::max(keep_end, std::min(end, begin + grid.align));
        found.push_back({from, std::min(whole, keep_end + grid.margin), begin, keep_end});
        begin = keep_end;
    }
    return found;
}

}  // namespace

std::vector<PicturePart> picture_parts(glm::ivec2 whole, const PictureRegion& region, int most_side,
                                       const FrameSettings& settings)
{
    const Grid grid = grid_of(settings);
    const int bottom = whole.y - region.y - region.height;
    const std::vector<Span> columns = spans(whole.x, region.x, region.width, most_side, grid);
    const std::vector<Span> rows = spans(whole.y, bottom, region.height, most_side, grid);
    std::vector<PicturePart> parts;
    for (const Span& y : rows)
        for (const Span& x : columns)
            parts.push_back({{x.begin, y.begin},
                             {x.end - x.begin, y.end - y.begin},
                             {x.keep_begin - x.begin, y.keep_begin - y.begin},
                             {x.keep_end - x.keep_begin, y.keep_end - y.keep_begin}});
    return parts;
}

glm::dmat4 clip_of_part(const glm::dmat4& clip_from_view, glm::ivec2 whole, const PicturePart& part)
{
    if (part.size == whole)
        return clip_from_view;
    const glm::dvec2 scale = glm::dvec2(whole) / glm::dvec2(part.size);
    const glm::dvec2 middle =
        (2.0 * glm::dvec2(part.origin) + glm::dvec2(part.size)) / glm::dvec2(whole) - 1.0;
    glm::dmat4 part_from_whole(1.0);
    part_from_whole[0][0] = scale.x;
    part_from_whole[1][1] = scale.y;
    part_from_whole[3][0] = -scale.x * middle.x;
    part_from_whole[3][1] = -scale.y * middle.y;
    return part_from_whole * clip_from_view;
}

}  // namespace fumarole
