#include "medium/occupancy.h"

#include <algorithm>

namespace fumarole::medium {

namespace {

enum class Part { whole, held };

/// The pages with more than `least`, or what of them holds something.
std::vector<OccupiedBox> kept_pages(const GridLayout& layout, Part part, float least = 0)
{
    std::vector<OccupiedBox> kept;
    std::size_t i = 0;
    for (int z = 0; z < layout.maxima_count.z; ++z)
        for (int y = 0; y < layout.maxima_count.y; ++y)
            for (int x = 0; x < layout.maxima_count.x; ++x, ++i) {
                const float most = layout.maxima[i];
                if (!(most > least))
                    continue;
                const glm::dvec3 first(layout.maxima_origin - layout.origin +
                                       glm::ivec3(x, y, z) * VoxelGrid::kBrickDim);
                const GridLayout::Extent extent =
                    part == Part::held
                        ? layout.extents[i]
                        : GridLayout::Extent{glm::u8vec3(0), glm::u8vec3(VoxelGrid::kBrickDim)};
                kept.push_back(
                    {{first + glm::dvec3(extent.min), first + glm::dvec3(extent.max)}, most});
            }
    return kept;
}

/// Where the field is not 0.
Bounds field_of(const GridLayout& layout)
{
    return {glm::dvec3(layout.field_min - layout.origin),
            glm::dvec3(layout.field_max - layout.origin)};
}

/// Pages joined by blocks of `side` along each edge, without what reaches out of the field.
std::vector<OccupiedBox> join(const std::vector<OccupiedBox>& pages, const GridLayout& layout,
                              int side)
{
    const glm::ivec3 blocks = (layout.maxima_count + side - 1) / side;
    std::vector<OccupiedBox> joined(static_cast<std::size_t>(blocks.x) *
                                    static_cast<std::size_t>(blocks.y) *
                                    static_cast<std::size_t>(blocks.z));
    const Bounds field = field_of(layout);
    for (const OccupiedBox& page : pages) {
        const glm::ivec3 first = glm::ivec3(page.bounds.min) + layout.origin - layout.maxima_origin;
        const glm::ivec3 block = first / (side * VoxelGrid::kBrickDim);
        const int i = (block.z * blocks.y + block.y) * blocks.x + block.x;
        OccupiedBox& box = joined[static_cast<std::size_t>(i)];
        box.bounds.add(glm::clamp(page.bounds.min, field.min, field.max));
        box.bounds.add(glm::clamp(page.bounds.max, field.min, field.max));
        box.most = std::max(box.most, page.most);
    }
    std::erase_if(joined, [](const OccupiedBox& box) { return !(box.most > 0); });
    return joined;
}

}  // namespace

std::vector<OccupiedBox> kept_boxes(const GridLayout& layout)
{
    std::vector<OccupiedBox> pages = kept_pages(layout, Part::whole);
    if (layout.layout == Layout::bricks || pages.empty())
        return pages;
    OccupiedBox all{field_of(layout), 0};
    for (const OccupiedBox& page : pages)
        all.most = std::max(all.most, page.most);
    return {all};
}

std::vector<OccupiedBox> occupied_boxes(const GridLayout& layout, std::size_t limit, float least)
{
    const std::vector<OccupiedBox> pages = kept_pages(layout, Part::held, least);
    for (int side = 1;; side *= 2) {
        std::vector<OccupiedBox> boxes = join(pages, layout, side);
        if (boxes.size() <= limit)
            return boxes;
    }
}

}  // namespace fumarole::medium
