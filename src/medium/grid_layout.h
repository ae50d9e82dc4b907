#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "medium/page_tree.h"
#include <fumarole/settings.h>
#include <fumarole/voxel_grid.h>

// A VoxelGrid laid out for the GPU, still on the CPU: either one dense 3-D texture, or an atlas of
// bricks and a page table. No GL here.

namespace fumarole::medium {

/// As OpenGL spells its texels, `R16F`; never of automatic.
std::string_view storage_name(Storage storage);

/// What the GL allows; asked of the context by the caller.
struct Limits {
    int max_texture_3d = 2048;                         ///< texels along an edge
    std::uint64_t max_bytes = std::uint64_t{4} << 30;  ///< bytes for one grid
};

/// An atlas brick holds its 8^3 voxels and one more layer on the +x, +y and +z sides, so hardware
/// trilinear filtering never leaves it: 9^3 texels.
inline constexpr int kAtlasBrickDim = 9;

/// A page is 32 bits: shared/brick_page.h. A constant is what a fetch would give, before
/// value_scale, within 2^-23 relative. Constants are of scalar grids alone; a vec3 page is 0 or a
/// brick.

/// Slots along an axis of the atlas that a page can name: 2304 texels.
inline constexpr int kMostSlotsPerAxis = 256;

/// A brick's scale, by which its texels are multiplied besides value_scale: 1 for floats; for r8 so
/// that 255 stands for the brick's largest value, rounded up by at most an eighth. A step is 2^20
/// of a float's bits, an eighth of the octave it lies in, and exact on any GPU.
inline constexpr int kScaleSteps = 127;

/// 1 at step 0, 1.125 * 2^-16 at the last: fainter bricks share that one.
float brick_scale(int step);

/// What rounding to bytes does to a grid, of bricks each with its own scale.
struct ByteError {
    double rms = 0;   ///< RMS of the error / RMS of the values
    double mean = 0;  ///< mean of the error relative to each value
    [[nodiscard]] bool is_small() const;
};

/// How to sample it at q = p_index - origin, exactly, with linear filtering: dense at texel
/// coordinate q + 0.5; bricks in page floor(q / 8) at slot * 9 + (q - 8 * page) + 0.5, times the
/// brick's scale, and 0 where the page is empty or past the table. Where most pages would be empty
/// or constant, the table is a tree instead, and maxima and extents are its nodes'. An empty grid's
/// layout has no texels, pages, maxima or extents.
struct GridLayout {
    Layout layout = Layout::dense;    ///< never automatic
    Storage storage = Storage::r16f;  ///< never automatic
    int channels = 1;                 ///< 1, or 4 for a vec3 grid (RGBA, alpha 0)

    std::string storage_reason;  ///< why this storage, for the user

    /// Stored value * value_scale (* the brick's scale) = the grid's value. A power of two for
    /// floats, so nothing is lost and half floats can't overflow; the largest value for r8.
    float value_scale = 1;

    /// Index of the voxel at texel (0,0,0): one layer of zeros is part of a dense texture on each
    /// side; for bricks a multiple of 8, the first voxel of page (0,0,0).
    glm::ivec3 origin{0};

    /// The box of index space outside which the field is 0: index_min - 1 .. index_max + 1.
    glm::ivec3 field_min{0}, field_max{0};

    glm::ivec3 texture_size{0};        ///< texels of the dense texture or of the atlas
    std::vector<std::uint8_t> texels;  ///< x fastest, tightly packed, in `storage`

    glm::ivec3 page_count{0};          ///< pages along x, y, z (bricks alone); of a tree entries
    std::vector<std::uint32_t> pages;  ///< x fastest

    /// Where `tree.levels` is not 0, `pages` holds its nodes as an atlas of 8^3 entries each: of
    /// the root at its first place. An entry is a page as of a table, except that in nodes above
    /// level 1 a brick's slot is the place of a node.
    PageTree tree;

    /// Upper bound of the stored field inside each page's cell [8b, 8b+8] (closed: its 9^3 corner
    /// values), all channels, times value_scale already, i.e. in the grid's units; x fastest. Made
    /// for both layouts; page (0,0,0) begins at maxima_origin, a multiple of 8.
    glm::ivec3 maxima_origin{0};
    glm::ivec3 maxima_count{0};
    std::vector<float> maxima;
    using Extent = PageExtent;
    std::vector<Extent> extents;

    /// Texels and pages (maxima and extents stay on the CPU); found from the sizes, so the same for
    /// a plan and what it makes.
    [[nodiscard]] std::uint64_t gpu_bytes() const;
};

/// The bytes and sizes a layout would take, found without making it (an `automatic` choice is
/// resolved): GridLayout with empty vectors.
/// Dense is chosen where it would not be larger than bricks of the same storage. Storage is r32f
/// where most of the grid lies under 2^-29 of its largest value, else r8 where its ByteError is
/// small, else r16f.
/// @throws Error with the size and the remedy if neither fits `limits`, or the asked one does not.
GridLayout plan_layout(const VoxelGrid& grid, Layout layout, Storage storage, const Limits& limits);

/// plan_layout, filled.
GridLayout make_layout(const VoxelGrid& grid, Layout layout, Storage storage, const Limits& limits);

}  // namespace fumarole::medium
