// The layout is described in asset/vdb_layout.cpp, which reads it.

#include "study/handmade_vdb.h"

#include <cstdint>
#include <cstring>
#include <map>

namespace fumarole::study {

namespace {

class Bytes {
public:
    template <class T> void put(const T& value)
    {
        text_.append(reinterpret_cast<const char*>(&value), sizeof(T));
    }
    void put_string(std::string_view text)
    {
        put(static_cast<std::uint32_t>(text.size()));
        text_ += text;
    }
    void put_raw(std::string_view text) { text_ += text; }
    /// Room for a file offset, to be told later.
    std::size_t reserve_offset()
    {
        put(std::int64_t{0});
        return text_.size() - sizeof(std::int64_t);
    }
    void set_offset(std::size_t at)
    {
        const auto here = static_cast<std::int64_t>(text_.size());
        std::memcpy(text_.data() + at, &here, sizeof(here));
    }
    [[nodiscard]] std::string take() { return std::move(text_); }

private:
    std::string text_;
};

/// Which of a node's 2^(3 log2_dim) places a voxel is in, children 2^child_log2 voxels wide.
/// OpenVDB counts z fastest.
std::uint32_t place_in_node(glm::ivec3 voxel, int log2_dim, int child_log2)
{
    std::uint32_t place = 0;
    for (int axis = 0; axis < 3; ++axis)
        place = place << log2_dim |
                static_cast<std::uint32_t>((voxel[axis] >> child_log2) & ((1 << log2_dim) - 1));
    return place;
}

using Leaves = std::map<std::uint32_t, const HandmadeBrick*>;  // by place in a node of 16^3
using Nodes = std::map<std::uint32_t, Leaves>;                 // by place in a node of 32^3
struct LessByAxes {
    bool operator()(const glm::ivec3& a, const glm::ivec3& b) const
    {
        return std::array{a.x, a.y, a.z} < std::array{b.x, b.y, b.z};
    }
};
using Roots = std::map<glm::ivec3, Nodes, LessByAxes>;  // by origin, 4096 voxels wide

template <class Children> void put_node(Bytes& bytes, const Children& children, int log2_dim)
{
    std::string mask(std::size_t{1} << (3 * log2_dim - 3), '\0');
    const std::string none = mask;
    for (const auto& [place, child] : children)
        mask[place >> 3] = static_cast<char>(mask[place >> 3] | 1 << (place & 7));
    bytes.put_raw(mask);         // children
    bytes.put_raw(none);         // active tiles
    bytes.put(std::uint8_t{0});  // values: of active tiles alone, the rest is the background
}

}  // namespace

std::string handmade_vdb(const HandmadeVdb& grid)
{
    Roots roots;
    for (const HandmadeBrick& brick : grid.bricks) {
        const glm::ivec3 voxel = brick.brick * 8;
        const glm::ivec3 origin(voxel.x & ~4095, voxel.y & ~4095, voxel.z & ~4095);
        roots[origin][place_in_node(voxel, 5, 7)][place_in_node(voxel, 4, 3)] = &brick;
    }

    Bytes bytes;
    bytes.put(std::uint64_t{0x56444220});  // "VDB "
    bytes.put(std::uint32_t{224});         // version of the file, then of the library
    bytes.put(std::uint32_t{10});
    bytes.put(std::uint32_t{0});
    bytes.put(std::uint8_t{1});  // offsets are meant
    bytes.put_raw("00000000-0000-0000-0000-000000000000");
    bytes.put(std::uint32_t{0});  // metadata of the file
    bytes.put(std::uint32_t{1});  // grids

    bytes.put_string("density");
    bytes.put_string("Tree_float_5_4_3");
    bytes.put_string("");  // shares no tree
    const std::array offsets{bytes.reserve_offset(), bytes.reserve_offset(),
                             bytes.reserve_offset()};
    bytes.set_offset(offsets[0]);
    bytes.put(std::uint32_t{2});  // compression: active values alone
    bytes.put(std::uint32_t{1});  // metadata of the grid
    bytes.put_string("class");
    bytes.put_string("string");
    bytes.put_string(grid.grid_class);
    bytes.put_string("AffineMap");
    bytes.put(grid.world_from_index);

    const std::string all(512 / 8, '\xff');
    bytes.put(std::uint32_t{1});  // buffers
    bytes.put(grid.background);
    bytes.put(std::uint32_t{0});  // tiles
    bytes.put(static_cast<std::uint32_t>(roots.size()));
    for (const auto& [origin, nodes] : roots) {
        bytes.put(origin);
        put_node(bytes, nodes, 5);
        for (const auto& [place, leaves] : nodes) {
            put_node(bytes, leaves, 4);
            for (std::size_t i = 0; i < leaves.size(); ++i)
                bytes.put_raw(all);
        }
    }
    bytes.set_offset(offsets[1]);
    for (const auto& [origin, nodes] : roots)
        for (const auto& [place, leaves] : nodes)
            for (const auto& [at, brick] : leaves) {
                bytes.put_raw(all);
                bytes.put(std::uint8_t{0});
                for (int i = 0; i < 512; ++i)  // z fastest here
                    bytes.put(brick->values[static_cast<std::size_t>((i >> 6) | (i >> 3 & 7) << 3 |
                                                                     (i & 7) << 6)]);
            }
    bytes.set_offset(offsets[2]);
    return bytes.take();
}

}  // namespace fumarole::study
