#include "medium/page_tree.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <map>
#include <span>

#include "medium/grid_cells.h"

namespace fumarole::medium {

namespace {

using Entry = PageTree::Entry;

/// A brick or a tile, or what of it one node sees.
struct Piece {
    glm::ivec3 lo, hi;  ///< bricks, inclusive
    int source;         ///< as in CellSources
};

bool meets(const Piece& piece, const glm::ivec3& lo, const glm::ivec3& hi)
{
    return glm::all(glm::lessThanEqual(piece.lo, hi)) && glm::all(glm::lessThanEqual(lo, piece.hi));
}

bool covers(const Piece& piece, const glm::ivec3& lo, const glm::ivec3& hi)
{
    return glm::all(glm::lessThanEqual(piece.lo, lo)) && glm::all(glm::lessThanEqual(hi, piece.hi));
}

/// What is thrown once the tree is larger than it may be.
struct TooLarge {};

class Builder {
public:
    Builder(const VoxelGrid& grid, std::uint64_t most_bytes) : grid_(grid), bytes_left_(most_bytes)
    {
    }

    PageTree build(const glm::ivec3& first_page, std::int64_t pages)
    {
        std::vector<Piece> pieces;
        for (std::size_t i = 0; i < grid_.bricks.size(); ++i)
            pieces.push_back({grid_.bricks[i], grid_.bricks[i], static_cast<int>(i) + 1});
        for (std::size_t i = 0; i < grid_.tiles.size(); ++i)
            pieces.push_back(
                {grid_.tiles[i].brick_min, grid_.tiles[i].brick_max, -static_cast<int>(i) - 1});
        tree_.levels = 1;
        while (std::int64_t{1} << (3 * tree_.levels) < pages)
            ++tree_.levels;
        // The shader begins at a node, whatever is in it.
        add_node(first_page, tree_.levels, pieces, false, true);
        return std::move(tree_);
    }

private:
    /// A page, or the pages of a node, from `lo` on.
    Entry entry(const glm::ivec3& lo, int level, std::span<const Piece> pieces)
    {
        // Tiles alone look the same wherever they lie.
        std::vector<int> key;
        if (std::all_of(pieces.begin(), pieces.end(),
                        [](const Piece& p) { return p.source < 0; })) {
            key = key_of(lo, level, pieces);
            if (const auto known = known_.find(key); known != known_.end())
                return known->second;
        }
        const Entry made = level == 0 ? add_leaf(lo, pieces, !key.empty())
                                      : add_node(lo, level, pieces, !key.empty(), false);
        if (!key.empty())
            known_.emplace(std::move(key), made);
        return made;
    }

    [[nodiscard]] std::vector<int> key_of(const glm::ivec3& lo, int level,
                                          std::span<const Piece> pieces) const
    {
        const int size = 1 << (3 * level);  // the next brick counts too
        std::vector<int> key{level};
        for (const Piece& piece : pieces) {
            const glm::ivec3 from = glm::max(piece.lo - lo, 0), to = glm::min(piece.hi - lo, size);
            const glm::vec3 value = grid_.tiles[static_cast<std::size_t>(-piece.source - 1)].value;
            for (int axis = 0; axis < 3; ++axis) {
                key.push_back(from[axis]);
                key.push_back(to[axis]);
                key.push_back(std::bit_cast<int>(value[axis]));
            }
        }
        return key;
    }

    void spend(std::uint64_t bytes)
    {
        if (bytes > bytes_left_)
            throw TooLarge();
        bytes_left_ -= bytes;
    }

    Entry constant(float value)
    {
        const auto [at, is_new] =
            constants_.emplace(value, -static_cast<Entry>(tree_.constants.size()) - 1);
        if (is_new)
            tree_.constants.push_back(value);
        return at->second;
    }

    /// @param tiles it has no bricks, so it may be known already
    Entry add_leaf(const glm::ivec3& page, std::span<const Piece> pieces, bool tiles)
    {
        PageTree::Leaf leaf;
        for (int corner = 0; corner < 8; ++corner) {
            const glm::ivec3 at = page + corner_offset(corner);
            for (const Piece& piece : pieces)
                if (covers(piece, at, at))
                    leaf.sources[static_cast<std::size_t>(corner)] = piece.source;
        }
        std::array<int, 24> values{};
        for (std::size_t i = 0; tiles && i < values.size(); ++i)
            if (const int source = leaf.sources[i / 3]; source < 0)
                values[i] = std::bit_cast<int>(grid_.tiles[static_cast<std::size_t>(-source - 1)]
                                                   .value[static_cast<int>(i % 3)]);
        if (const auto known = leaves_.find(values); tiles && known != leaves_.end())
            return known->second;
        const Entry made = add_leaf(leaf);
        if (tiles)
            leaves_.emplace(values, made);
        return made;
    }

    Entry add_leaf(PageTree::Leaf& leaf)
    {
        read_cell(grid_, leaf.sources, cell_);
        if (cell_.max <= 0)
            return 0;
        if (cell_.uniform && grid_.channels == 1)
            return constant(cell_.max);
        spend(kCellVoxels * static_cast<std::uint64_t>(grid_.channels));
        leaf.most = cell_.max;
        leaf.extent = extent_of(cell_, grid_.channels);
        tree_.leaves.push_back(leaf);
        return static_cast<Entry>(tree_.leaves.size());
    }

    Entry add_node(const glm::ivec3& lo, int level, std::span<const Piece> pieces, bool tiles,
                   bool is_root)
    {
        PageTree::Node node;
        node.level = level;
        fill(node, lo, lo, 3 * level, pieces);
        const Entry first = node.entries[0];
        const bool is_one = std::all_of(node.entries.begin(), node.entries.end(),
                                        [&](Entry e) { return e <= 0 && e == first; });
        if (is_one && !is_root)
            return first;
        const auto key = std::pair{level, node.entries};
        if (const auto known = nodes_.find(key); tiles && known != nodes_.end())
            return known->second;
        measure(node);
        spend(sizeof(std::uint32_t) * PageTree::kNodeEntries);
        tree_.nodes.push_back(node);
        const auto made = static_cast<Entry>(tree_.nodes.size());
        if (tiles)
            nodes_.emplace(key, made);
        return made;
    }

    /// The entries of `node`, which begins at page `node_lo`, of the 2^log2 pages along each axis
    /// from `lo` on.
    void fill(PageTree::Node& node, const glm::ivec3& node_lo, const glm::ivec3& lo, int log2,
              std::span<const Piece> pieces)
    {
        if (pieces.empty())
            return;
        const int child_log2 = 3 * (node.level - 1);
        const glm::ivec3 place = (lo - node_lo) >> child_log2;
        const bool is_constant = pieces.size() == 1 && pieces[0].source < 0 &&
                                 grid_.channels == 1 && covers(pieces[0], lo, lo + (1 << log2));
        if (is_constant) {
            const Entry value =
                constant(grid_.tiles[static_cast<std::size_t>(-pieces[0].source - 1)].value.x);
            const int side = 1 << (log2 - child_log2);
            for (int z = 0; z < side; ++z)
                for (int y = 0; y < side; ++y)
                    std::fill_n(node.entries.begin() + number(place + glm::ivec3(0, y, z)), side,
                                value);
            return;
        }
        if (log2 == child_log2) {
            node.entries[static_cast<std::size_t>(number(place))] =
                entry(lo, node.level - 1, pieces);
            return;
        }
        const int half = 1 << (log2 - 1);
        std::vector<Piece> inside;
        for (int octant = 0; octant < 8; ++octant) {
            const glm::ivec3 sub_lo = lo + half * corner_offset(octant);
            inside.clear();
            for (const Piece& piece : pieces)
                if (meets(piece, sub_lo, sub_lo + half))  // the next brick ends the last cell
                    inside.push_back(piece);
            fill(node, node_lo, sub_lo, log2 - 1, inside);
        }
    }

    static int number(const glm::ivec3& place)
    {
        return (place.z * PageTree::kNodeDim + place.y) * PageTree::kNodeDim + place.x;
    }

    void measure(PageTree::Node& node) const
    {
        node.min = glm::i64vec3(std::numeric_limits<std::int64_t>::max());
        node.max = glm::i64vec3(std::numeric_limits<std::int64_t>::min());
        const std::int64_t voxels = PageTree::entry_voxels(node.level);
        for (int i = 0; i < PageTree::kNodeEntries; ++i) {
            const Entry e = node.entries[static_cast<std::size_t>(i)];
            if (e == 0)
                continue;
            const glm::i64vec3 corner = voxels * glm::i64vec3(i & 7, i >> 3 & 7, i >> 6);
            glm::i64vec3 min(0), max(voxels);
            if (e > 0 && node.level == 1) {
                const PageExtent& extent = tree_.leaves[static_cast<std::size_t>(e - 1)].extent;
                min = extent.min;
                max = extent.max;
            } else if (e > 0) {
                const PageTree::Node& child = tree_.nodes[static_cast<std::size_t>(e - 1)];
                min = child.min;
                max = child.max;
            }
            node.min = glm::min(node.min, corner + min);
            node.max = glm::max(node.max, corner + max);
        }
    }

    const VoxelGrid& grid_;
    std::uint64_t bytes_left_;
    PageTree tree_;
    // Of tiles alone: what was met where they lie so, and what came of it.
    std::map<std::vector<int>, Entry> known_;
    std::map<std::array<int, 24>, Entry> leaves_;  ///< leaves by the values at their corners
    std::map<std::pair<int, std::array<Entry, PageTree::kNodeEntries>>, Entry> nodes_;
    std::map<float, Entry> constants_;
    Cell cell_{};
};

}  // namespace

void PageTree::sum_up()
{
    for (Node& node : nodes) {
        node.most = 0;
        for (const Entry e : node.entries) {
            const float most = e == 0            ? 0
                               : e < 0           ? constants[static_cast<std::size_t>(-e - 1)]
                               : node.level == 1 ? leaves[static_cast<std::size_t>(e - 1)].most
                                                 : nodes[static_cast<std::size_t>(e - 1)].most;
            node.most = std::max(node.most, most);
        }
    }
}

std::optional<PageTree> make_page_tree(const VoxelGrid& grid, glm::ivec3 first_page,
                                       std::int64_t pages, std::uint64_t most_bytes)
{
    try {
        PageTree tree = Builder(grid, most_bytes).build(first_page, pages);
        tree.sum_up();
        return tree;
    } catch (const TooLarge&) {
        return std::nullopt;
    }
}

}  // namespace fumarole::medium
