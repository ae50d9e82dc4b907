#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <string>
#include <vector>

// What lies where in a .vdb file (or a .nvdb: nanovdb_layout.h), with every size, count and offset
// checked against the bytes that are there.
//
// OpenVDB believes what a file says: a forged length makes it write past its buffers or ask for
// gigabytes, and a file cut short is read as zeros. So a file is walked here first, with no OpenVDB
// at all, and OpenVDB is handed only trees whose every chunk was found to fit.

namespace fumarole::asset {

/// The type of a tree's values, as far as it can be loaded.
enum class VdbValue { float32, float64, vec3f, vec3d, other };

struct NanoGrid;  // nanovdb_layout.h

/// One grid of a file.
struct VdbGridLayout {
    std::string name;        ///< as its author called it: may be empty, and several may share one
    std::string address;     ///< unique: `density`, or `density[1]`
    std::string value_type;  ///< as OpenVDB's type names have it: `float`, `vec3s`, `ptdataidx32`
    VdbValue value = VdbValue::other;  ///< `other` too for trees that are not 5, 4, 3
    std::string grid_class;            ///< `fog volume`, `level set`, `staggered`, `unknown`, ...
    bool half = false;                 ///< the file holds 16-bit floats

    std::string transform;                    ///< the map's type, e.g. `AffineMap`
    glm::dmat4 world_from_index{1.0};         ///< only where transform_refusal is empty
    std::string transform_refusal;            ///< "", or why the transform is of no use
    std::map<std::string, std::string> text;  ///< metadata that is text

    /// Metadata written beside the grid, believed only where the tree is not read.
    glm::ivec3 claimed_min{1}, claimed_max{0};
    std::int64_t claimed_voxels = 0;
    bool claims = false;  ///< true if the metadata that claims this is there

    std::uint32_t compression = 0;  ///< OpenVDB's flags: 1 zip, 2 active values only, 4 blosc
    std::size_t tree_begin = 0;     ///< bytes of the tree in the file, checked to the last chunk
    std::size_t tree_end = 0;       ///< == tree_begin for `other`
    std::uint64_t leaves = 0;
    std::uint64_t tree_bytes = 0;  ///< bytes of memory that OpenVDB takes for the expanded tree

    std::shared_ptr<NanoGrid> nano;  ///< the tree of a NanoVDB file; null for a .vdb
};

/// A whole file in memory and its map.
struct VdbLayout {
    std::filesystem::path file;
    std::unique_ptr<char[]> bytes;
    std::size_t size = 0;
    std::uint32_t file_version = 0;  ///< 222..224; 0 for NanoVDB
    std::uint32_t library_major = 0;
    std::uint32_t library_minor = 0;
    std::string creator;
    std::vector<VdbGridLayout> grids;  ///< grids in the file's order
};

/// How much of a file is read. `headers`: no tree, of which `tree_end` and `leaves` are not known
/// then; the bytes between them are not read at all.
enum class VdbDepth { headers, all };

/// Reads a file and walks all of it. Memory: the file's size, and little else; a compressed .nvdb
/// is held expanded too.
/// @throws Error naming the file and the byte: not there, no VDB, of another version, damaged, cut
/// short; larger than memory_limit(). LoadCancelled.
VdbLayout read_vdb_layout(const std::filesystem::path& file, VdbDepth depth = VdbDepth::all);

/// Why a transform is of no use, or "": not finite, not affine, not to be inverted.
std::string transform_refusal(const glm::dmat4& world_from_index);

}  // namespace fumarole::asset
