#include "medium/occupancy.h"

#include <algorithm>

namespace fumarole::medium {

namespace {

/// The pages that are not empty, joined by blocks of `pages` along each edge.
std::vector<OccupiedBox> join(const GridLayout& layout, int pages)
{
    const glm::ivec3 count = layout.maxima_count;
    const glm::ivec3 blocks = (count + pages - 1) / pages;
    const auto at = [](glm::ivec3 p, glm::ivec3 size) {
        return (static_cast<std::size_t>(p.z) * static_cast<std::size_t>(size.y) +
                static_cast<std::size_t>(p.y)) *
                   static_cast<std::size_t>(size.x) +
               static_cast<std::size_t>(p.x);
    };
    std::vector<OccupiedBox> joined(at(blocks - 1, blocks) + 1);
    const glm::dvec3 low(layout.field_min - layout.origin), high(layout.field_max - layout.origin);
    for (int z = 0; z < count.z; ++z)
        for (int y = 0; y < count.y; ++y)
            for (int x = 0; x < count.x; ++x) {
                const glm::ivec3 page(x, y, z);
                const float most = layout.maxima[at(page, count)];
                if (!(most > 0))
                    continue;
                const glm::dvec3 first(layout.maxima_origin - layout.origin +
                                       page * VoxelGrid::kBrickDim);
                OccupiedBox& box = joined[at(page / pages, blocks)];
                box.bounds.add(glm::clamp(first, low, high));
                box.bounds.add(
                    glm::clamp(first + static_cast<double>(VoxelGrid::kBrickDim), low, high));
                box.most = std::max(box.most, most);
            }
    std::erase_if(joined, [](const OccupiedBox& box) { return !(box.most > 0); });
    return joined;
}

}  // namespace

std::vector<OccupiedBox> occupied_boxes(const GridLayout& layout, std::size_t limit)
{
    if (layout.maxima.empty())
        return {};
    for (int pages = 1;; pages *= 2) {
        std::vector<OccupiedBox> boxes = join(layout, pages);
        if (boxes.size() <= limit)
            return boxes;
    }
}

}  // namespace fumarole::medium
