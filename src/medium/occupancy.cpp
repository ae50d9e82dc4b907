#include "medium/occupancy.h"

#include <algorithm>
#include <cstdint>
#include <queue>

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

/// What an entry of a tree's nodes covers.
struct TreePart {
    glm::i64vec3 min{0}, max{0};  ///< voxels from the layout's origin: where it is not 0
    glm::i64vec3 corner{0};
    float most = 0;
    int node = -1;  ///< -1: it has no entries of its own

    [[nodiscard]] double volume() const
    {
        const glm::dvec3 size(max - min);
        return size.x * size.y * size.z;
    }
};

/// The parts of a node with more than `least`.
std::vector<TreePart> parts_of(const PageTree& tree, const TreePart& whole, float least)
{
    std::vector<TreePart> parts;
    const PageTree::Node& node = tree.nodes[static_cast<std::size_t>(whole.node)];
    const std::int64_t voxels = PageTree::entry_voxels(node.level);
    for (int i = 0; i < PageTree::kNodeEntries; ++i) {
        const PageTree::Entry entry = node.entries[static_cast<std::size_t>(i)];
        if (entry == 0)
            continue;
        const auto at = static_cast<std::size_t>(std::abs(entry) - 1);
        TreePart part;
        part.corner = whole.corner + voxels * glm::i64vec3(i & 7, i >> 3 & 7, i >> 6);
        if (entry < 0) {
            part.most = tree.constants[at];
            part.max = glm::i64vec3(voxels);
        } else if (node.level == 1) {
            const PageTree::Leaf& leaf = tree.leaves[at];
            part.most = leaf.most;
            part.min = leaf.extent.min;
            part.max = leaf.extent.max;
        } else {
            const PageTree::Node& child = tree.nodes[at];
            part.most = child.most;
            part.min = child.min;
            part.max = child.max;
            part.node = static_cast<int>(at);
        }
        part.min += part.corner;
        part.max += part.corner;
        if (part.most > least)
            parts.push_back(part);
    }
    return parts;
}

/// Boxes of a tree with more than `least`, the largest cut into those of its node's entries as long
/// as there are no more than `limit`.
std::vector<OccupiedBox> tree_boxes(const GridLayout& layout, std::size_t limit, float least)
{
    const auto smaller = [](const TreePart& a, const TreePart& b) {
        return a.volume() < b.volume();
    };
    std::priority_queue<TreePart, std::vector<TreePart>, decltype(smaller)> open(smaller);
    std::vector<TreePart> whole;
    const PageTree& tree = layout.tree;
    TreePart root;
    root.node = static_cast<int>(tree.nodes.size()) - 1;
    root.min = tree.nodes.back().min;
    root.max = tree.nodes.back().max;
    root.most = tree.nodes.back().most;
    if (root.most > least)
        open.push(root);
    while (!open.empty()) {
        const TreePart part = open.top();
        open.pop();
        const std::vector<TreePart> parts = parts_of(tree, part, least);
        if (open.size() + whole.size() + parts.size() > limit) {
            whole.push_back(part);
            continue;
        }
        for (const TreePart& one : parts)
            if (one.node >= 0)
                open.push(one);
            else
                whole.push_back(one);
    }
    const Bounds field = field_of(layout);
    std::vector<OccupiedBox> boxes;
    for (const TreePart& part : whole) {
        OccupiedBox box;
        box.bounds.add(glm::clamp(glm::dvec3(part.min), field.min, field.max));
        box.bounds.add(glm::clamp(glm::dvec3(part.max), field.min, field.max));
        box.most = part.most;
        boxes.push_back(box);
    }
    return boxes;
}

/// The widest gap between boxes along an axis, in parts of what they fill of it.
struct Gap {
    double width = 0;
    int axis = 0;
    double begin = 0;  ///< what ends before or here lies on its one side
};

Gap widest_gap(const std::vector<Bounds>& boxes)
{
    Gap widest;
    for (int axis = 0; axis < 3; ++axis) {
        std::vector<glm::dvec2> spans;
        spans.reserve(boxes.size());
        for (const Bounds& box : boxes)
            spans.emplace_back(box.min[axis], box.max[axis]);
        std::sort(spans.begin(), spans.end(), [](glm::dvec2 a, glm::dvec2 b) { return a.x < b.x; });
        double filled = 0, end = spans.front().x, gap = 0, begin = 0;
        for (const glm::dvec2 span : spans) {
            if (span.x - end > gap) {
                gap = span.x - end;
                begin = end;
            }
            filled += std::max(0.0, span.y - std::max(span.x, end));
            end = std::max(end, span.y);
        }
        if (gap > widest.width * filled)
            widest = {gap / filled, axis, begin};
    }
    return widest;
}

}  // namespace

std::vector<OccupiedBox> kept_boxes(const GridLayout& layout, std::size_t limit)
{
    if (layout.tree.levels > 0)
        return tree_boxes(layout, limit, 0);
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
    if (layout.tree.levels > 0)
        return tree_boxes(layout, limit, least);
    const std::vector<OccupiedBox> pages = kept_pages(layout, Part::held, least);
    for (int side = 1;; side *= 2) {
        std::vector<OccupiedBox> boxes = join(pages, layout, side);
        if (boxes.size() <= limit)
            return boxes;
    }
}

std::vector<Bounds> islands(const std::vector<OccupiedBox>& boxes, std::size_t limit)
{
    struct Group {
        std::vector<Bounds> boxes;
        Gap gap;

        explicit Group(std::vector<Bounds> of) : boxes(std::move(of)), gap(widest_gap(boxes)) {}
    };
    std::vector<Bounds> all;
    all.reserve(boxes.size());
    for (const OccupiedBox& box : boxes)
        all.push_back(box.bounds);
    if (all.empty())
        return {};
    std::vector<Group> groups{Group(std::move(all))};
    while (groups.size() < limit) {
        const auto loosest =
            std::max_element(groups.begin(), groups.end(), [](const Group& a, const Group& b) {
                return a.gap.width < b.gap.width;
            });
        if (!(loosest->gap.width > 1))
            break;
        const Gap gap = loosest->gap;
        std::vector<Bounds> before, after;
        for (const Bounds& box : loosest->boxes)
            (box.max[gap.axis] <= gap.begin ? before : after).push_back(box);
        *loosest = Group(std::move(before));
        groups.emplace_back(std::move(after));
    }
    std::vector<Bounds> around;
    for (const Group& group : groups) {
        Bounds& one = around.emplace_back();
        for (const Bounds& box : group.boxes) {
            one.add(box.min);
            one.add(box.max);
        }
    }
    return around;
}

}  // namespace fumarole::medium
