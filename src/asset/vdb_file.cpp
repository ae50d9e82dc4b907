#include <fumarole/asset/vdb_file.h>

#include <fmt/format.h>
#include <openvdb/io/io.h>
#include <openvdb/tree/InternalNode.h>
#include <openvdb/tree/LeafNode.h>
#include <openvdb/tree/RootNode.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <istream>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <streambuf>
#include <tuple>
#include <type_traits>

#include "asset/grid_names.h"
#include "asset/nanovdb_layout.h"
#include "asset/printable.h"
#include "asset/vdb_layout.h"
#include <fumarole/asset/load_limits.h>
#include <fumarole/errors.h>

// vdb_layout.h finds the trees in a file and proves that they are whole; OpenVDB expands them
// (those of NanoVDB are made its own); here they become bricks and tiles, which are 0 outside of
// what is stored, finite, and >= 0.

namespace fumarole::asset {

namespace {

constexpr int kBrickDim = VoxelGrid::kBrickDim;
constexpr int kBrickVoxels = VoxelGrid::kBrickVoxels;

/// Indices beyond this are refused, so that whoever adds a voxel's rim or takes an extent stays
/// within 32 bits.
constexpr int kMaxIndex = (1 << 30) + kBrickDim - 1;
constexpr std::int64_t kMaxExtent = (std::int64_t(1) << 31) - 4096;

// A root is all of a tree that is needed, and openvdb::tree::Tree would have its every virtual
// function compiled for every type of value: three times as long.
template <class T> using LeafOf = openvdb::tree::LeafNode<T, 3>;
template <class T>
using RootOf = openvdb::tree::RootNode<
    openvdb::tree::InternalNode<openvdb::tree::InternalNode<LeafOf<T>, 4>, 5>>;

template <class T> constexpr int kChannels = std::is_arithmetic_v<T> ? 1 : 3;

template <class T> double channel(const T& value, int c)
{
    if constexpr (std::is_arithmetic_v<T>)
        return double(value);
    else
        return double(value[c]);
}

glm::ivec3 to_ivec3(const openvdb::Coord& v)
{
    return {v.x(), v.y(), v.z()};
}

openvdb::Coord to_coord(glm::ivec3 v)
{
    return {v.x, v.y, v.z};
}

glm::ivec3 brick_of(glm::ivec3 index)
{
    return {index.x >> 3, index.y >> 3, index.z >> 3};
}

/// Along z, then y, then x: the order of VoxelGrid::bricks.
bool brick_before(const glm::ivec3& a, const glm::ivec3& b)
{
    return std::tie(a.z, a.y, a.x) < std::tie(b.z, b.y, b.x);
}

struct IndexBox {
    glm::ivec3 min{std::numeric_limits<int>::max()};
    glm::ivec3 max{std::numeric_limits<int>::min()};

    [[nodiscard]] bool empty() const { return min.x > max.x; }
    void add(glm::ivec3 lo, glm::ivec3 hi)
    {
        min = glm::min(min, lo);
        max = glm::max(max, hi);
    }
    [[nodiscard]] bool contains(glm::ivec3 v) const
    {
        return glm::all(glm::lessThanEqual(min, v)) && glm::all(glm::lessThanEqual(v, max));
    }
};

/// What was wrong with active values, in single numbers.
struct Tally {
    std::uint64_t nan = 0, inf = 0, negative = 0;

    void operator+=(const Tally& other)
    {
        nan += other.nan;
        inf += other.inf;
        negative += other.negative;
    }
};

/// What VoxelGrid promises of its values, from what a file may hold.
struct Cleaner {
    /// Half the width of a level set's band, or 0 for values that are densities already.
    double band = 0;
    bool negatives = false;  ///< velocities keep theirs

    float operator()(double v, std::uint64_t voxels, Tally& tally) const
    {
        if (std::isnan(v)) {
            tally.nan += voxels;
            return 0;
        }
        if (std::abs(v) > double(std::numeric_limits<float>::max())) {
            tally.inf += voxels;
            return 0;
        }
        // As openvdb::tools::sdfToFogVolume has it: 1 inside, a ramp to 0 over the inner half of
        // the band. Done per value, it needs no second tree.
        if (band > 0)
            return v < 0 ? float(std::min(1.0, -v / band)) : 0.0f;
        if (v < 0 && !negatives) {
            tally.negative += voxels;
            return 0;
        }
        return float(v);
    }
};

/// Lets OpenVDB read from a range of memory.
class MemoryBuffer : public std::streambuf {
public:
    MemoryBuffer(const std::filesystem::path& file, const char* bytes, std::size_t size)
        : file_(file)
    {
        char* begin = const_cast<char*>(bytes);  // streambuf's get area is never written to
        setg(begin, begin, begin + size);
    }

protected:
    pos_type seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode) override
    {
        // OpenVDB asks where it is before each leaf, and seeks only in files that it opened itself.
        check_cancelled(file_);
        return from == std::ios_base::cur && offset == 0 ? pos_type(gptr() - eback())
                                                         : pos_type(off_type(-1));
    }

private:
    const std::filesystem::path& file_;
};

/// Makes OpenVDB's tree of a NanoVDB one.
template <class T> class NanoTree : public NanoVisitor {
public:
    std::unique_ptr<RootOf<T>> root;

    void background(const void* value) override
    {
        root = std::make_unique<RootOf<T>>(number(value));
    }
    void tile(glm::ivec3 origin, int dim, const void* value, bool active) override
    {
        const T number = this->number(value);
        if (active || number != root->background())
            root->addTile(dim == 4096 ? 3 : dim == 128 ? 2 : 1, to_coord(origin), number, active);
    }
    void leaf(glm::ivec3 origin, const void* values, const std::uint64_t* active) override
    {
        auto leaf = std::make_unique<LeafOf<T>>(to_coord(origin));
        std::memcpy(leaf->buffer().data(), values, sizeof(T) * LeafOf<T>::SIZE);
        typename LeafOf<T>::NodeMaskType mask;
        for (openvdb::Index i = 0; i < LeafOf<T>::SIZE; ++i)
            if (active[i / 64] >> (i % 64) & 1)
                mask.setOn(i);
        leaf->setValueMask(mask);
        root->addLeaf(leaf.release());
    }

private:
    static T number(const void* value)
    {
        T result;
        std::memcpy(&result, value, sizeof(T));
        return result;
    }
};

template <class T>
std::unique_ptr<RootOf<T>> read_tree(const VdbLayout& file, const VdbGridLayout& grid)
{
    check_memory(file.file, file.size + grid.tree_bytes);
    try {
        if (grid.nano) {
            NanoTree<T> tree;
            visit_nanovdb(file, grid, tree);
            return std::move(tree.root);
        }
        auto root = std::make_unique<RootOf<T>>();
        constexpr std::size_t kBufferCount = sizeof(std::int32_t);  // Tree's, before the root's own
        const std::size_t begin = grid.tree_begin + kBufferCount;
        MemoryBuffer buffer(file.file, file.bytes.get() + begin, grid.tree_end - begin);
        std::istream in(&buffer);
        in.exceptions(std::ios_base::failbit | std::ios_base::badbit);
        openvdb::io::setVersion(in, {file.library_major, file.library_minor}, file.file_version);
        openvdb::io::setDataCompression(in, grid.compression);
        root->readTopology(in, grid.half);
        root->readBuffers(in, grid.half);
        return root;
    } catch (const LoadCancelled&) {
        throw;
    } catch (const std::bad_alloc&) {
        throw Error(fmt::format("{}: grid '{}' does not fit into memory", file.file.string(),
                                printable(grid.address)));
    } catch (const std::exception& e) {
        throw Error(fmt::format("{}: damaged: grid '{}': {}", file.file.string(),
                                printable(grid.address), printable(e.what())));
    }
}

/// A constant region of a tree, of `dim`^3 voxels; not active ones too.
template <class T> struct TreeTile {
    glm::ivec3 origin;
    int dim;
    T value;
    bool active;

    [[nodiscard]] glm::ivec3 last() const { return origin + (dim - 1); }
    [[nodiscard]] std::uint64_t voxels() const
    {
        const auto n = std::uint64_t(dim);
        return n * n * n;
    }
};

/// Calls `on_tile(TreeTile)` and `on_leaf(const Leaf&)` for all that is in a tree.
template <class T, class Node, class OnTile, class OnLeaf>
void visit(const Node& node, const OnTile& on_tile, const OnLeaf& on_leaf)
{
    using Child = typename Node::ChildNodeType;
    for (auto it = node.cbeginValueAll(); it; ++it)
        on_tile(TreeTile<T>{to_ivec3(it.getCoord()), int(Child::DIM), *it, it.isValueOn()});
    for (auto it = node.cbeginChildOn(); it; ++it) {
        if constexpr (std::is_same_v<Child, LeafOf<T>>)
            on_leaf(*it);
        else
            visit<T>(*it, on_tile, on_leaf);
    }
}

/// Calls `use` with a null pointer of the type of a grid's values. The grid is not `other`.
template <class Use> void with_value_type(VdbValue value, const Use& use)
{
    switch (value) {
    case VdbValue::float32:
        return use(static_cast<float*>(nullptr));
    case VdbValue::float64:
        return use(static_cast<double*>(nullptr));
    case VdbValue::vec3f:
        return use(static_cast<openvdb::Vec3f*>(nullptr));
    case VdbValue::vec3d:
        return use(static_cast<openvdb::Vec3d*>(nullptr));
    case VdbValue::other:
        break;
    }
}

bool is_scalar(const VdbGridLayout& grid)
{
    return grid.value == VdbValue::float32 || grid.value == VdbValue::float64;
}

bool is_level_set(const VdbGridLayout& grid)
{
    return is_scalar(grid) && grid.grid_class == "level set";
}

std::string value_type(const VdbGridLayout& grid)
{
    if (!grid.half)
        return grid.value_type;
    return grid.value == VdbValue::float32 ? "half" : grid.value_type + " as half";
}

/// `'temperature' float fog volume`
std::string describe(const VdbGridLayout& grid)
{
    std::string text = fmt::format("'{}' {}", printable(grid.address), value_type(grid));
    if (grid.grid_class != "unknown")
        text += " " + grid.grid_class;
    return text;
}

/// `(has: 'temperature' float fog volume, 'v' vec3s)`
std::string list_grids(const VdbLayout& file)
{
    constexpr std::size_t kMostListed = 20;
    if (file.grids.empty())
        return "(has no grids)";
    std::string text = "(has: ";
    for (std::size_t i = 0; i < std::min(kMostListed, file.grids.size()); ++i)
        text += (i ? ", " : "") + describe(file.grids[i]);
    if (file.grids.size() > kMostListed)
        text += fmt::format(", and {} more", file.grids.size() - kMostListed);
    return text + ")";
}

std::string refusal(const VdbGridLayout& grid)
{
    if (grid.value == VdbValue::other)
        return fmt::format("its values are of type {}; float, double and vec3 are read",
                           grid.value_type);
    return grid.transform_refusal;
}

// --- A tree's bricks and tiles ------------------------------------------------------------------

/// A brick on its way into a VoxelGrid: a leaf, or background that an edge of the active box cuts.
template <class Leaf> struct BrickSource {
    glm::ivec3 brick;
    const Leaf* leaf;
};

template <class Leaf> void add_active(const Leaf& leaf, IndexBox& box)
{
    openvdb::CoordBBox of_leaf;
    leaf.evalActiveBoundingBox(of_leaf);
    if (!of_leaf.empty())
        box.add(to_ivec3(of_leaf.min()), to_ivec3(of_leaf.max()));
}

struct BrickSummary {
    IndexBox box;  ///< bounds of what is not 0
    float max = 0;
    Tally tally;
};

/// Fills in bricks, values, tiles, bounds and counts of a grid.
template <class T> class BrickBuilder {
public:
    BrickBuilder(const RootOf<T>& root, const Cleaner& clean) : root_(root), clean_(clean) {}

    void build(VoxelGrid& grid, Tally& tally, std::vector<std::string>& notes);

private:
    using Leaf = LeafOf<T>;

    static constexpr int kTreeChannels = kChannels<T>;

    glm::vec3 clean(const T& value, std::uint64_t voxels, Tally& tally) const
    {
        glm::vec3 result(0);
        for (int c = 0; c < kTreeChannels; ++c)
            result[c] = clean_(channel(value, c), voxels, tally);
        return result;
    }

    void add_tile(const TreeTile<T>& tile, VoxelGrid& grid, Tally& tally) const;
    void add_background(VoxelGrid& grid, std::vector<std::string>& notes);
    BrickSummary fill(const BrickSource<Leaf>& source, float* out) const;

    const RootOf<T>& root_;
    const Cleaner clean_;
    glm::vec3 background_{0};  ///< cleaned; 0 for nearly every file
    IndexBox active_;          ///< bounds of the active voxels
    std::vector<BrickSource<Leaf>> sources_;
};

template <class T>
void BrickBuilder<T>::add_tile(const TreeTile<T>& tile, VoxelGrid& grid, Tally& tally) const
{
    if (!tile.active && background_ != glm::vec3(0))
        return;  // add_background's
    Tally ignored;
    const glm::vec3 value = clean(tile.value, tile.voxels(), tile.active ? tally : ignored);
    if (value != glm::vec3(0))
        grid.tiles.push_back({brick_of(tile.origin), brick_of(tile.last()), value});
}

// A background other than 0 would fill all of space. It is kept where the file's own samplers meet
// it in between active voxels, that is inside the box of the active voxels, and is 0 outside.
template <class T>
void BrickBuilder<T>::add_background(VoxelGrid& grid, std::vector<std::string>& notes)
{
    constexpr std::int64_t kMostBricks = 1 << 18;  // a box of 512^3 voxels

    const glm::ivec3 lo = brick_of(active_.min), hi = brick_of(active_.max);
    const glm::dvec3 size = glm::dvec3(hi) - glm::dvec3(lo) + 1.0;
    const bool fills = size.x * size.y * size.z <= double(kMostBricks);
    notes.push_back(fmt::format(
        "background {} is taken as 0 outside of the active voxels' box{}",
        kTreeChannels == 1
            ? fmt::format("{:g}", background_.x)
            : fmt::format("({:g}, {:g}, {:g})", background_.x, background_.y, background_.z),
        fills ? "" : ", and inside it in bricks that hold no voxel"));
    if (!fills)
        return;

    for (int z = lo.z; z <= hi.z; ++z)
        for (int y = lo.y; y <= hi.y; ++y) {
            VoxelTile* row = nullptr;  // the tile that the brick before belongs to
            for (int x = lo.x; x <= hi.x; ++x) {
                const glm::ivec3 brick(x, y, z), origin = brick * kBrickDim;
                const openvdb::Coord coord = to_coord(origin);
                if (root_.probeConstLeaf(coord) || root_.isValueOn(coord)) {
                    row = nullptr;
                    continue;
                }
                if (!active_.contains(origin) || !active_.contains(origin + kBrickDim - 1)) {
                    sources_.push_back({brick, nullptr});
                    row = nullptr;
                    continue;
                }
                Tally ignored;
                const glm::vec3 value = clean(root_.getValue(coord), 1, ignored);
                if (row && row->value == value) {
                    row->brick_max.x = x;
                } else if (value != glm::vec3(0)) {
                    row = &grid.tiles.emplace_back(VoxelTile{brick, brick, value});
                } else {
                    row = nullptr;
                }
            }
        }
}

template <class T>
BrickSummary BrickBuilder<T>::fill(const BrickSource<Leaf>& source, float* out) const
{
    BrickSummary summary;
    Tally ignored;
    const glm::ivec3 origin = source.brick * kBrickDim;
    const T* values = source.leaf ? source.leaf->buffer().data() : nullptr;
    const bool clip = background_ != glm::vec3(0);
    for (int x = 0; x < kBrickDim; ++x)
        for (int y = 0; y < kBrickDim; ++y)
            for (int z = 0; z < kBrickDim; ++z) {
                const glm::ivec3 index = origin + glm::ivec3(x, y, z);
                if (clip && !active_.contains(index))
                    continue;
                const int from = (x * kBrickDim + y) * kBrickDim + z;
                const int to = (z * kBrickDim + y) * kBrickDim + x;
                glm::vec3 value;
                if (source.leaf) {
                    const bool active = source.leaf->isValueOn(openvdb::Index(from));
                    value = clean(values[from], 1, active ? summary.tally : ignored);
                } else {
                    value = clean(root_.getValue(to_coord(index)), 1, ignored);
                }
                if (value == glm::vec3(0))
                    continue;
                for (int c = 0; c < kTreeChannels; ++c) {
                    out[to * kTreeChannels + c] = value[c];
                    summary.max = std::max(summary.max, std::abs(value[c]));
                }
                summary.box.add(index, index);
            }
    return summary;
}

template <class T>
void BrickBuilder<T>::build(VoxelGrid& grid, Tally& tally, std::vector<std::string>& notes)
{
    grid.channels = kTreeChannels;
    Tally ignored;
    background_ = clean(root_.background(), 1, ignored);
    visit<T>(
        root_,
        [&](const TreeTile<T>& tile) {
            add_tile(tile, grid, tally);
            if (tile.active) {
                grid.active_voxels += tile.voxels();
                active_.add(tile.origin, tile.last());
            }
        },
        [&](const Leaf& leaf) {
            sources_.push_back({brick_of(to_ivec3(leaf.origin())), &leaf});
            grid.active_voxels += leaf.onVoxelCount();
            add_active(leaf, active_);
        });
    if (background_ != glm::vec3(0) && !active_.empty())
        add_background(grid, notes);
    std::ranges::sort(sources_, brick_before, &BrickSource<Leaf>::brick);

    constexpr std::size_t kStride = std::size_t(kBrickVoxels) * kTreeChannels;
    grid.values.resize(sources_.size() * kStride);
    std::vector<BrickSummary> summaries(sources_.size());
    tbb::parallel_for(std::size_t(0), sources_.size(), [&](std::size_t i) {
        summaries[i] = fill(sources_[i], grid.values.data() + i * kStride);
    });

    IndexBox box;
    for (std::size_t i = 0; i < sources_.size(); ++i) {
        const BrickSummary& summary = summaries[i];
        tally += summary.tally;
        if (summary.box.empty())
            continue;
        const std::size_t to = grid.bricks.size();
        if (to != i)
            std::copy_n(grid.values.data() + i * kStride, kStride,
                        grid.values.data() + to * kStride);
        grid.bricks.push_back(sources_[i].brick);
        grid.max_value = std::max(grid.max_value, summary.max);
        box.add(summary.box.min, summary.box.max);
    }
    grid.values.resize(grid.bricks.size() * kStride);

    std::ranges::sort(grid.tiles, brick_before, &VoxelTile::brick_min);
    for (const VoxelTile& tile : grid.tiles) {
        for (int c = 0; c < kTreeChannels; ++c)
            grid.max_value = std::max(grid.max_value, std::abs(tile.value[c]));
        // In this order: 8 * brick_max + 7 may be the largest int there is.
        box.add(tile.brick_min * kBrickDim, tile.brick_max * kBrickDim + (kBrickDim - 1));
    }
    if (!box.empty()) {
        grid.index_min = box.min;
        grid.index_max = box.max;
    }
}

// --- One grid -----------------------------------------------------------------------------------

void refuse(const VdbLayout& file, const VdbGridLayout& grid, const std::string& why)
{
    throw Error(
        fmt::format("{}: grid {} can't be read: {}", file.file.string(), describe(grid), why));
}

void check_bounds(const VdbLayout& file, const VdbGridLayout& layout, const VoxelGrid& grid)
{
    if (grid.empty())
        return;
    for (int axis = 0; axis < 3; ++axis) {
        const std::int64_t lo = grid.index_min[axis], hi = grid.index_max[axis];
        if (lo < -kMaxIndex || hi > kMaxIndex || hi - lo > kMaxExtent)
            refuse(file, layout,
                   fmt::format("its voxels reach from index {} to {}, more than can be addressed",
                               lo, hi));
    }
}

LoadedGrid load(const VdbLayout& file, const VdbGridLayout& layout, bool negatives = false)
{
    if (const std::string why = refusal(layout); !why.empty())
        refuse(file, layout, why);

    LoadedGrid loaded;
    VoxelGrid& grid = loaded.grid;
    grid.name = layout.address;
    grid.world_from_index = layout.world_from_index;
    grid.stored_as_half = layout.half;

    Tally tally;
    std::vector<std::string> notes;
    with_value_type(layout.value, [&]<class T>(T*) {
        check_memory(file.file, file.size + layout.tree_bytes +
                                    layout.leaves * kBrickVoxels * kChannels<T> * sizeof(float));
        const auto root = read_tree<T>(file, layout);
        Cleaner clean;
        clean.negatives = negatives;
        if (is_level_set(layout) && !negatives) {
            clean.band = channel(root->background(), 0);
            if (!(clean.band > 0) || !std::isfinite(clean.band))
                refuse(file, layout, fmt::format("a level set whose band is {} wide", clean.band));
            notes.emplace_back("a level set, made into fog: 1 inside, a ramp to 0 at its surface");
        }
        check_cancelled(file.file);
        BrickBuilder<T>(*root, clean).build(grid, tally, notes);
    });
    check_bounds(file, layout, grid);

    if (layout.grid_class == "staggered")
        notes.emplace_back("staggered values are taken as those of the voxels' centres");
    if (tally.nan)
        notes.push_back(
            fmt::format("{} NaN value{} read as 0", tally.nan, tally.nan == 1 ? "" : "s"));
    if (tally.inf)
        notes.push_back(
            fmt::format("{} infinite value{} read as 0", tally.inf, tally.inf == 1 ? "" : "s"));
    if (tally.negative)
        notes.push_back(fmt::format("{} negative value{} read as 0", tally.negative,
                                    tally.negative == 1 ? "" : "s"));
    if (grid.empty())
        notes.emplace_back("empty: nothing in it is above 0");
    for (const std::string& note : notes)
        loaded.notes.push_back(
            fmt::format("{}: grid '{}': {}", file.file.string(), printable(layout.address), note));
    return loaded;
}

// --- Three grids into one -----------------------------------------------------------------------

/// Merges three scalar grids into the channels of one. Where one has a brick and another a tile,
/// the tile is cut: boxes of 2^n bricks are halved along every axis until each holds only whole
/// tiles, or is one brick.
class ChannelMerger {
public:
    ChannelMerger(const std::array<LoadedGrid, 3>& parts, VoxelGrid& result)
        : parts_(parts), result_(result)
    {
    }

    void merge()
    {
        std::vector<Piece> pieces;
        for (int c = 0; c < 3; ++c) {
            const VoxelGrid& grid = part(c);
            for (std::size_t i = 0; i < grid.bricks.size(); ++i)
                pieces.push_back({c, int(i), false, grid.bricks[i], grid.bricks[i]});
            for (std::size_t i = 0; i < grid.tiles.size(); ++i)
                pieces.push_back(
                    {c, int(i), true, grid.tiles[i].brick_min, grid.tiles[i].brick_max});
        }
        // Bricks of 32-bit indices lie within +-2^28.
        split(glm::ivec3(-(1 << 28)), 29, pieces);

        std::ranges::sort(bricks_, brick_before, &Brick::brick);
        std::ranges::sort(result_.tiles, brick_before, &VoxelTile::brick_min);
        result_.values.resize(bricks_.size() * kBrickVoxels * 3);
        for (std::size_t i = 0; i < bricks_.size(); ++i) {
            result_.bricks.push_back(bricks_[i].brick);
            for (int c = 0; c < 3; ++c)
                for (std::size_t v = 0; v < std::size_t(kBrickVoxels); ++v)
                    result_.values[(i * kBrickVoxels + v) * 3 + std::size_t(c)] =
                        bricks_[i].source[c] < 0
                            ? bricks_[i].constant[c]
                            : part(c).values[std::size_t(bricks_[i].source[c]) * kBrickVoxels + v];
        }
    }

private:
    struct Piece {
        int channel;
        int index;
        bool tile;
        glm::ivec3 lo, hi;  ///< bricks, inclusive
    };
    struct Brick {
        glm::ivec3 brick;
        glm::ivec3 source{-1};  ///< per channel a brick of the part, or -1
        glm::vec3 constant{0};  ///< where there is none
    };

    [[nodiscard]] const VoxelGrid& part(int c) const { return parts_[std::size_t(c)].grid; }

    void split(glm::ivec3 lo, int log2_size, const std::vector<Piece>& pieces)
    {
        if (pieces.empty())
            return;
        const glm::ivec3 hi = lo + ((1 << log2_size) - 1);
        const bool whole = std::ranges::all_of(pieces, [&](const Piece& p) {
            return p.tile && glm::all(glm::lessThanEqual(p.lo, lo)) &&
                   glm::all(glm::lessThanEqual(hi, p.hi));
        });
        if (whole || log2_size == 0) {
            Brick brick{lo};
            for (const Piece& p : pieces) {
                if (p.tile)
                    brick.constant[p.channel] = part(p.channel).tiles[std::size_t(p.index)].value.x;
                else
                    brick.source[p.channel] = p.index;
            }
            if (whole)
                result_.tiles.push_back({lo, hi, brick.constant});
            else
                bricks_.push_back(brick);
            return;
        }
        const int half = 1 << (log2_size - 1);
        std::vector<Piece> inside;
        for (int octant = 0; octant < 8; ++octant) {
            const glm::ivec3 sub_lo =
                lo + half * glm::ivec3(octant & 1, octant >> 1 & 1, octant >> 2);
            const glm::ivec3 sub_hi = sub_lo + (half - 1);
            inside.clear();
            std::ranges::copy_if(pieces, std::back_inserter(inside), [&](const Piece& p) {
                return glm::all(glm::lessThanEqual(p.lo, sub_hi)) &&
                       glm::all(glm::lessThanEqual(sub_lo, p.hi));
            });
            split(sub_lo, log2_size - 1, inside);
        }
    }

    const std::array<LoadedGrid, 3>& parts_;
    VoxelGrid& result_;
    std::vector<Brick> bricks_;
};

LoadedGrid load_channels(const VdbLayout& file, const std::string& name,
                         const std::array<const VdbGridLayout*, 3>& layouts, bool negatives)
{
    std::array<LoadedGrid, 3> parts;
    LoadedGrid loaded;
    VoxelGrid& grid = loaded.grid;
    grid.name = name;
    grid.channels = 3;
    grid.stored_as_half = true;
    IndexBox box;
    for (std::size_t c = 0; c < 3; ++c) {
        const VdbGridLayout& layout = *layouts[c];
        if (!is_scalar(layout))
            refuse(
                file, layout,
                fmt::format("as a channel of '{}' it must hold single numbers", printable(name)));
        if (layout.world_from_index != layouts[0]->world_from_index)
            throw Error(fmt::format("{}: '{}' and '{}' have different transforms, so they can't be "
                                    "the channels of one grid '{}'",
                                    file.file.string(), printable(layouts[0]->address),
                                    printable(layout.address), printable(name)));
        parts[c] = load(file, layout, negatives);
        const VoxelGrid& part = parts[c].grid;
        loaded.notes.insert(loaded.notes.end(), parts[c].notes.begin(), parts[c].notes.end());
        grid.active_voxels = std::max(grid.active_voxels, part.active_voxels);
        grid.max_value = std::max(grid.max_value, part.max_value);
        grid.stored_as_half = grid.stored_as_half && part.stored_as_half;
        if (!part.empty())
            box.add(part.index_min, part.index_max);
    }
    grid.world_from_index = parts[0].grid.world_from_index;
    if (!box.empty()) {
        grid.index_min = box.min;
        grid.index_max = box.max;
    }
    ChannelMerger(parts, grid).merge();
    check_bounds(file, *layouts[0], grid);
    return loaded;
}

// --- Which grid ---------------------------------------------------------------------------------

std::vector<GridName> names_of(const VdbLayout& file)
{
    std::vector<GridName> names;
    for (const VdbGridLayout& grid : file.grids)
        names.push_back({grid.address, grid.name});
    return names;
}

std::vector<GridName> names_of(const VdbInfo& file)
{
    std::vector<GridName> names;
    for (const GridInfo& grid : file.grids)
        names.push_back({grid.name, std::string(without_number(grid.name))});
    return names;
}

LoadedGrid load_default(const VdbLayout& file)
{
    std::vector<const VdbGridLayout*> candidates;
    const VdbGridLayout* refused = nullptr;
    for (const VdbGridLayout& grid : file.grids) {
        if (is_scalar(grid) && refusal(grid).empty())
            candidates.push_back(&grid);
        else if (is_scalar(grid) && !refused)
            refused = &grid;
    }
    if (candidates.empty() && refused)
        refuse(file, *refused, refusal(*refused));
    std::ranges::stable_sort(
        candidates, {}, [](const VdbGridLayout* g) { return fog_rank(g->name, g->grid_class); });

    std::set<std::pair<std::size_t, bool>> empty_trees;  // several grids may share one
    for (const VdbGridLayout* candidate : candidates) {
        const std::pair tree(candidate->tree_begin, is_level_set(*candidate));
        if (empty_trees.contains(tree))
            continue;
        LoadedGrid loaded = load(file, *candidate);
        if (loaded.grid.empty()) {
            empty_trees.insert(tree);
            continue;
        }
        if (candidate != candidates.front())
            loaded.notes.push_back(fmt::format("{}: read '{}', for '{}' is empty",
                                               file.file.string(), printable(candidate->address),
                                               printable(candidates.front()->address)));
        return loaded;
    }
    const bool has_vectors = std::ranges::any_of(file.grids, [](const VdbGridLayout& grid) {
        return grid.value == VdbValue::vec3f || grid.value == VdbValue::vec3d;
    });
    throw Error(
        fmt::format("{}: {}{} {}", file.file.string(),
                    candidates.empty() ? "no grid to take as fog" : "nothing above 0 in any grid",
                    has_vectors          ? "; a vec3 grid must be asked for by name"
                    : candidates.empty() ? "; grids of floats are, write one"
                                         : "",
                    list_grids(file)));
}

// --- Description --------------------------------------------------------------------------------

template <class T> void measure(const RootOf<T>& root, GridInfo& info)
{
    info.min = std::numeric_limits<double>::infinity();
    info.max = -std::numeric_limits<double>::infinity();
    double sum = 0, finite = 0;
    glm::dvec3 vector_sum(0);
    const auto add = [&](const T& value, std::uint64_t voxels) {
        double square = 0;
        bool any_nan = false, any_inf = false, any_negative = false;
        for (int c = 0; c < kChannels<T>; ++c) {
            const double v = channel(value, c);
            any_nan = any_nan || std::isnan(v);
            any_inf = any_inf || std::isinf(v);
            any_negative = any_negative || v < 0;
            square += v * v;
        }
        info.nan_count += any_nan ? voxels : 0;
        info.inf_count += any_inf ? voxels : 0;
        info.negative_count += any_negative ? voxels : 0;
        if (any_nan || any_inf)
            return;
        const double v = kChannels<T> == 1 ? channel(value, 0) : std::sqrt(square);
        for (int c = 0; c < kChannels<T>; ++c)
            vector_sum[c] += channel(value, c) * double(voxels);
        info.min = std::min(info.min, v);
        info.max = std::max(info.max, v);
        sum += v * double(voxels);
        finite += double(voxels);
    };
    IndexBox active;
    visit<T>(
        root,
        [&](const TreeTile<T>& tile) {
            if (!tile.active)
                return;
            ++info.active_tiles;
            info.active_voxels += tile.voxels();
            active.add(tile.origin, tile.last());
            add(tile.value, tile.voxels());
        },
        [&](const LeafOf<T>& leaf) {
            info.active_voxels += leaf.onVoxelCount();
            add_active(leaf, active);
            for (auto it = leaf.cbeginValueOn(); it; ++it)
                add(*it, 1);
        });
    if (!active.empty()) {
        info.index_min = active.min;
        info.index_max = active.max;
    }
    if (finite == 0)
        info.min = info.max = 0;
    info.mean = finite > 0 ? sum / finite : 0;
    if (kChannels<T> == 3 && finite > 0)
        info.mean_vector = vector_sum / finite;
}

/// In world space: the box of the active voxels, each with the half voxel around its centre.
void place(GridInfo& info)
{
    for (int axis = 0; axis < 3; ++axis)
        info.voxel_size[axis] = glm::length(glm::dvec3(info.world_from_index[axis]));
    if (glm::any(glm::greaterThan(info.index_min, info.index_max)))
        return;
    info.world_min = glm::dvec3(std::numeric_limits<double>::infinity());
    info.world_max = -info.world_min;
    for (int corner = 0; corner < 8; ++corner) {
        glm::dvec3 p_index;
        for (int axis = 0; axis < 3; ++axis)
            p_index[axis] =
                corner >> axis & 1 ? info.index_max[axis] + 0.5 : info.index_min[axis] - 0.5;
        const glm::dvec3 p_world = info.world_from_index * glm::dvec4(p_index, 1);
        info.world_min = glm::min(info.world_min, p_world);
        info.world_max = glm::max(info.world_max, p_world);
    }
}

/// All that is said of a grid beside its values.
void describe(const VdbGridLayout& grid, GridInfo& about)
{
    about.name = printable(grid.address);
    about.value_type = value_type(grid);
    about.grid_class = grid.grid_class;
    about.transform = printable(grid.transform);
    about.world_from_index = grid.world_from_index;
    about.leaf_bricks = grid.leaves;
    about.refusal = refusal(grid);
    about.world_min = about.world_max = glm::dvec3(0);
    if (grid.transform_refusal.empty())
        place(about);
}

void believe_claims(const VdbGridLayout& grid, GridInfo& about)
{
    about.index_min = grid.claimed_min;
    about.index_max = grid.claimed_max;
    about.active_voxels = std::uint64_t(grid.claimed_voxels);
}

VdbInfo file_info(const VdbLayout& layout)
{
    VdbInfo info;
    info.file = layout.file;
    info.file_bytes = layout.size;
    info.creator = layout.creator;
    return info;
}

}  // namespace

VdbInfo inspect_vdb(const std::filesystem::path& file)
{
    const VdbLayout layout = read_vdb_layout(file);
    VdbInfo info = file_info(layout);
    std::map<std::size_t, std::size_t> measured;  // grids by the place of the tree they share
    for (const VdbGridLayout& grid : layout.grids) {
        GridInfo about;
        const auto twin = measured.find(grid.tree_begin);
        if (grid.value != VdbValue::other && twin != measured.end()) {
            about = info.grids[twin->second];
        } else if (grid.value != VdbValue::other) {
            with_value_type(grid.value,
                            [&]<class T>(T*) { measure<T>(*read_tree<T>(layout, grid), about); });
            measured.emplace(grid.tree_begin, info.grids.size());
        } else {
            believe_claims(grid, about);
        }
        describe(grid, about);
        info.grids.push_back(std::move(about));
    }
    return info;
}

VdbInfo read_vdb_headers(const std::filesystem::path& file)
{
    const VdbLayout layout = read_vdb_layout(file, VdbDepth::headers);
    if (!std::ranges::all_of(layout.grids, &VdbGridLayout::claims))
        return inspect_vdb(file);
    VdbInfo info = file_info(layout);
    for (const VdbGridLayout& grid : layout.grids) {
        GridInfo about;
        believe_claims(grid, about);
        if (about.active_voxels > 0)
            about.max = std::numeric_limits<double>::infinity();
        describe(grid, about);
        info.grids.push_back(std::move(about));
    }
    return info;
}

std::vector<const GridInfo*> fog_candidates(const VdbInfo& file)
{
    std::vector<const GridInfo*> candidates;
    for (const GridInfo& grid : file.grids)
        if (grid.refusal.empty() && !grid.value_type.starts_with("vec3"))
            candidates.push_back(&grid);
    std::ranges::stable_sort(candidates, {}, [](const GridInfo* grid) {
        return fog_rank(without_number(grid->name), grid->grid_class);
    });
    return candidates;
}

bool has_grid(const VdbInfo& file, const std::string& name)
{
    if (name.empty())
        return !fog_candidates(file).empty();
    const std::vector<GridName> names = names_of(file);
    return find_name(names, name) || find_channels(names, name);
}

std::uint64_t voxels_in(const VdbInfo& file, const std::string& name)
{
    std::uint64_t voxels = 0;
    const std::vector<GridName> names = names_of(file);
    if (name.empty()) {
        for (const GridInfo* grid : fog_candidates(file))
            voxels = std::max(voxels, grid->active_voxels);
    } else if (const auto grid = find_name(names, name)) {
        voxels = file.grids[*grid].active_voxels;
    } else if (const auto channels = find_channels(names, name)) {
        for (const std::size_t channel : *channels)
            voxels = std::max(voxels, file.grids[channel].active_voxels);
    }
    return voxels;
}

namespace {

LoadedGrid load_named(const VdbLayout& layout, const std::string& name, bool negatives)
{
    const std::vector<GridName> names = names_of(layout);
    if (const auto grid = find_name(names, name))
        return load(layout, layout.grids[*grid], negatives);
    if (const auto found = find_channels(names, name)) {
        std::array<const VdbGridLayout*, 3> channels{};
        for (std::size_t c = 0; c < 3; ++c)
            channels[c] = &layout.grids[(*found)[c]];
        return load_channels(layout, name, channels, negatives);
    }
    throw Error(fmt::format("{}: no grid '{}' {}", layout.file.string(), printable(name),
                            list_grids(layout)));
}

}  // namespace

LoadedGrid load_grid(const std::filesystem::path& file, const std::string& name)
{
    const VdbLayout layout = read_vdb_layout(file);
    return name.empty() ? load_default(layout) : load_named(layout, name, false);
}

LoadedGrid load_vectors(const std::filesystem::path& file, const std::string& name)
{
    LoadedGrid loaded = load_named(read_vdb_layout(file), name, true);
    if (loaded.grid.channels != 3)
        throw Error(fmt::format("{}: grid '{}' has one number a voxel, and a velocity needs three "
                                "(a vec3 grid, or name.x, name.y and name.z)",
                                file.string(), printable(name)));
    return loaded;
}

}  // namespace fumarole::asset
