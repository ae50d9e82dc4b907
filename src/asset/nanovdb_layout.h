#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "asset/vdb_layout.h"

// NanoVDB files (.nvdb), versions 32.0 and later: what lies where, every offset checked before it
// is followed. The format is that of NanoVDB.h and io/IO.h; no code of theirs is used, since it
// believes what a file says.

namespace fumarole::asset {

class LazyBytes;

/// The values that a NanoVDB leaf is made of: numbers of full width, or codes of n bits between the
/// leaf's own extremes.
enum class NanoValue { float32, float64, vec3f, fp4, fp8, fp16, fpn };

/// One grid's buffer as NanoVDB has it in memory: grid, tree, root, upper, lower and leaf nodes,
/// linked by offsets.
struct NanoGrid {
    NanoValue value = NanoValue::float32;
    /// What a compressed file holds, maybe with other grids; null: the file has it plain.
    std::shared_ptr<const std::vector<char>> expanded;
    std::size_t begin = 0;  ///< where the buffer begins in `expanded`, or else in the file
    std::size_t size = 0;   ///< bytes
};

/// Takes a tree apart. Values are of the grid's VdbValue: float, double, or three of them.
class NanoVisitor {
public:
    virtual ~NanoVisitor() = default;
    virtual void background(const void* value) = 0;
    /// A constant cube of `dim` voxels: 4096, 128 or 8.
    virtual void tile(glm::ivec3 origin, int dim, const void* value, bool active) = 0;
    /// 512 values, z fastest, and a bit for each that is active.
    virtual void leaf(glm::ivec3 origin, const void* values, const std::uint64_t* active) = 0;
};

/// Whether a file begins as NanoVDB's do.
bool is_nanovdb(const VdbLayout& layout, LazyBytes& bytes);

/// Fills in a layout: all but the grids' addresses.
/// @throws Error naming the file and the byte; LoadCancelled
void read_nanovdb_layout(VdbLayout& layout, LazyBytes& bytes, VdbDepth depth);

/// Visits a grid that read_nanovdb_layout found whole. @throws LoadCancelled
void visit_nanovdb(const VdbLayout& layout, const VdbGridLayout& grid, NanoVisitor& visitor);

}  // namespace fumarole::asset
