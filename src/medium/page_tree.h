#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>
#include <optional>
#include <vector>

#include <fumarole/voxel_grid.h>

// A page table for grids whose bricks lie far apart, or whose tiles are so large that a table with
// a number for every 8^3 voxels would not fit: a tree of nodes of 8^3 entries. Parts of the grid
// that are alike share one node (a directed graph, as Kaempe et al. 2013 have it for surfaces), so
// that a constant tile takes a few nodes and bricks for its faces, whatever its size.

namespace fumarole::medium {

/// Of a page's cell, in voxels from its corner, the box outside which the field is 0.
struct PageExtent {
    glm::u8vec3 min{0}, max{0};
};

/// What the 8 bricks at a page and after it are: 0 for nothing, a brick's number + 1, or
/// -(a tile's number + 1); x fastest.
using CellSources = std::array<int, 8>;

struct PageTree {
    static constexpr int kNodeDim = 8;
    static constexpr int kNodeEntries = kNodeDim * kNodeDim * kNodeDim;

    /// 0: nothing is there. < 0: the field is constants[-entry - 1] all through. > 0: nodes[entry -
    /// 1], or, in a node of level 1, leaves[entry - 1].
    using Entry = std::int32_t;

    /// A page that is a brick of the atlas.
    struct Leaf {
        CellSources sources{};
        float most = 0;  ///< as GridLayout::maxima
        PageExtent extent;
    };

    /// A node of level n covers 8^n pages along each axis.
    struct Node {
        std::array<Entry, kNodeEntries> entries{};  ///< x fastest
        int level = 1;
        float most = 0;
        /// Where the field inside is not 0, in voxels from the node's corner.
        glm::i64vec3 min{0}, max{0};
    };

    int levels = 0;           ///< level of the root, which is the last node; 0: there is no tree
    std::vector<Node> nodes;  ///< children before parents
    std::vector<Leaf> leaves;
    std::vector<float> constants;  ///< values of constant nodes, of scalar grids alone

    /// Voxels along the edge of what an entry of a node of that level covers.
    [[nodiscard]] static std::int64_t entry_voxels(int level)
    {
        return std::int64_t{VoxelGrid::kBrickDim} << (3 * (level - 1));
    }

    /// Finds `most` of all nodes anew, from those of leaves and constants.
    void sum_up();
};

/// The tree over the pages from `first_page` on.
/// @param pages along the longest axis
/// @param most_bytes that its nodes, and its leaves at one byte a texel, may take
/// @returns nothing if they take more
std::optional<PageTree> make_page_tree(const VoxelGrid& grid, glm::ivec3 first_page,
                                       std::int64_t pages, std::uint64_t most_bytes);

}  // namespace fumarole::medium
