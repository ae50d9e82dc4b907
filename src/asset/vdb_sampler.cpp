#include "asset/vdb_sampler.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <openvdb/Types.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tree/InternalNode.h>
#include <openvdb/tree/LeafNode.h>
#include <openvdb/tree/RootNode.h>
#include <openvdb/tree/ValueAccessor.h>
#include <variant>

#include <fumarole/asset/vdb_file.h>

namespace fumarole::asset {

namespace {

/// OpenVDB's nodes and accessors without its Tree, whose virtual functions (files, printing, ...)
/// would all be compiled here, for three types: a minute of it.
template <class T> struct TreeOf {
    using RootNodeType = openvdb::tree::RootNode<openvdb::tree::InternalNode<
        openvdb::tree::InternalNode<openvdb::tree::LeafNode<T, 3>, 4>, 5>>;
    using LeafNodeType = typename RootNodeType::LeafNodeType;
    using ValueType = T;
    static constexpr openvdb::Index DEPTH = RootNodeType::LEVEL + 1;

    explicit TreeOf(const T& background) : root_{background} {}
    RootNodeType& root() { return root_; }
    const RootNodeType& root() const { return root_; }
    /// What keeps accessors of a tree that changes; these never do while they have any.
    void attachAccessor(openvdb::tree::ValueAccessorBase<const TreeOf, false>&) const {}
    void releaseAccessor(openvdb::tree::ValueAccessorBase<const TreeOf, false>&) const {}

private:
    RootNodeType root_;
};
using ScalarTree = TreeOf<float>;
using VectorTree = TreeOf<openvdb::Vec3f>;
using IndexTree = TreeOf<std::int32_t>;
/// Not registered with its tree, which would lock it: trees here never change.
template <class Tree> using Accessor = openvdb::tree::ValueAccessor<const Tree, false>;

constexpr int kBrickDim = VoxelGrid::kBrickDim;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

openvdb::Coord to_coord(glm::ivec3 v)
{
    return {v.x, v.y, v.z};
}

void read(float value, double& out)
{
    out = static_cast<double>(value);
}
void read(const openvdb::Vec3f& value, glm::dvec3& out)
{
    out = {value[0], value[1], value[2]};
}

template <class T> T value_at(const VoxelGrid& grid, std::size_t voxel);
template <> float value_at<float>(const VoxelGrid& grid, std::size_t voxel)
{
    return grid.values[voxel];
}
template <> openvdb::Vec3f value_at<openvdb::Vec3f>(const VoxelGrid& grid, std::size_t voxel)
{
    return {grid.values[3 * voxel], grid.values[3 * voxel + 1], grid.values[3 * voxel + 2]};
}

/// Which bricks have cells that hold something: one voxel of the index for each.
constexpr std::int32_t kEmptyBrick = 0, kFilledBrick = -1;  ///< above 0: number of its PaddedBrick

template <class Tree> std::unique_ptr<Tree> build(const VoxelGrid& grid, IndexTree& index)
{
    using T = typename Tree::ValueType;
    auto tree = std::make_unique<Tree>(T(0));
    const auto touch = [&](glm::ivec3 first_brick, glm::ivec3 last_brick) {
        // A cell reaches one voxel on, so a brick's values fill cells of the bricks before it too.
        index.root().fill({to_coord(first_brick - 1), to_coord(last_brick)}, kFilledBrick, true);
    };
    for (const VoxelTile& tile : grid.tiles) {
        T value;
        if constexpr (std::is_same_v<T, float>)
            value = tile.value.x;
        else
            value = T(tile.value.x, tile.value.y, tile.value.z);
        tree->root().fill({to_coord(tile.brick_min * kBrickDim),
                           to_coord(tile.brick_max * kBrickDim + (kBrickDim - 1))},
                          value, true);
        touch(tile.brick_min, tile.brick_max);
    }
    for (std::size_t b = 0; b < grid.bricks.size(); ++b) {
        auto* leaf = tree->root().touchLeaf(to_coord(grid.bricks[b] * kBrickDim));
        for (int z = 0; z < kBrickDim; ++z)
            for (int y = 0; y < kBrickDim; ++y)
                for (int x = 0; x < kBrickDim; ++x) {
                    const auto from = static_cast<std::size_t>((z * kBrickDim + y) * kBrickDim + x);
                    const auto to =
                        static_cast<openvdb::Index>((x * kBrickDim + y) * kBrickDim + z);
                    leaf->setValueOn(to, value_at<T>(grid, b * VoxelGrid::kBrickVoxels + from));
                }
        touch(grid.bricks[b], grid.bricks[b]);
    }
    return tree;
}

/// A brick with the first values of the bricks after it: all that its cells need, x running
/// fastest. Walking a ray takes most of the reference's time, and searching the tree took most of
/// that.
struct PaddedBrick {
    static constexpr int kDim = kBrickDim + 1;
    std::array<float, static_cast<std::size_t>(kDim* kDim* kDim)> values;
};

/// Copies of the bricks' values, as many as memory may hold; the others are left to the tree.
std::vector<PaddedBrick> pad(const ScalarTree& tree, const VoxelGrid& grid, IndexTree& index)
{
    constexpr std::size_t kMostBytes = std::size_t(1) << 29u;
    std::vector<PaddedBrick> padded;
    const Accessor<ScalarTree> accessor(tree);
    const auto add = [&](glm::ivec3 brick) {
        const openvdb::Coord at = to_coord(brick);
        if (index.root().getValue(at) != kFilledBrick ||
            padded.size() * sizeof(PaddedBrick) > kMostBytes)
            return;
        PaddedBrick& one = padded.emplace_back();
        float* to = one.values.data();
        for (int z = 0; z < PaddedBrick::kDim; ++z)
            for (int y = 0; y < PaddedBrick::kDim; ++y)
                for (int x = 0; x < PaddedBrick::kDim; ++x)
                    *to++ = accessor.getValue(to_coord(brick * kBrickDim + glm::ivec3(x, y, z)));
        index.root().setValueOn(at, static_cast<std::int32_t>(padded.size()));
    };
    for (const glm::ivec3 brick : grid.bricks)
        for (int i = 0; i < 8; ++i)
            add(brick - glm::ivec3(i & 1, i >> 1 & 1, i >> 2));
    return padded;
}

/// The trilinear field of one cell as sum of a[i + 2j + 4k] x^i y^j z^k over the unit cube.
template <class Value> struct Cell {
    using Number = Value;
    std::array<Value, 8> a;

    template <class Tree> void fetch(const Accessor<Tree>& accessor, glm::ivec3 cell)
    {
        const glm::ivec3 in = cell & (kBrickDim - 1);
        const openvdb::Coord coord = to_coord(cell);
        const auto* leaf =
            in.x < 7 && in.y < 7 && in.z < 7 ? accessor.probeConstLeaf(coord) : nullptr;
        if (leaf != nullptr) {
            // All corners in one leaf: no search. A leaf's z runs fastest.
            const auto* values = leaf->buffer().data() + (in.x * 64 + in.y * 8 + in.z);
            for (std::size_t i = 0; i < 8; ++i)
                read(values[(i & 1) * 64 + (i >> 1 & 1) * 8 + (i >> 2)], a[i]);
        } else {
            typename Tree::ValueType data[2][2][2];
            openvdb::tools::BoxSampler::getValues(data, accessor, coord);
            for (std::size_t i = 0; i < 8; ++i)
                read(data[i & 1][i >> 1 & 1][i >> 2], a[i]);
        }
        for (std::size_t axis = 1; axis < 8; axis *= 2)
            for (std::size_t i = 0; i < 8; ++i)
                if ((i & axis) != 0)
                    a[i] -= a[i - axis];
    }

    void fetch(const PaddedBrick& brick, glm::ivec3 in)
    {
        constexpr int kY = PaddedBrick::kDim, kZ = kY * kY;
        const float* v = brick.values.data() + (in.z * kZ + in.y * kY + in.x);
        for (const int k : {0, 1}) {
            const auto i = static_cast<std::size_t>(4 * k);
            const float* w = v + std::ptrdiff_t(k) * kZ;
            a[i] = Value(static_cast<double>(w[0]));
            a[i + 1] = Value(static_cast<double>(w[1])) - a[i];
            a[i + 2] = Value(static_cast<double>(w[kY])) - a[i];
            a[i + 3] = Value(static_cast<double>(w[kY + 1])) - a[i] - a[i + 1] - a[i + 2];
        }
        for (const std::size_t i : {0, 1, 2, 3})
            a[i + 4] -= a[i];
    }

    [[nodiscard]] Value at(glm::dvec3 f) const
    {
        return (a[0] + a[1] * f.x) + (a[2] + a[3] * f.x) * f.y +
               ((a[4] + a[5] * f.x) + (a[6] + a[7] * f.x) * f.y) * f.z;
    }

    /// Its integral along f + s * d, s in [0, ds]: two points of Gauss serve a cubic exactly.
    [[nodiscard]] Value integral(glm::dvec3 f, glm::dvec3 d, double ds) const
    {
        constexpr double kNode = 0.21132486540518712;  // (1 - 1 / sqrt(3)) / 2
        return (at(f + d * (ds * kNode)) + at(f + d * (ds * (1 - kNode)))) * (0.5 * ds);
    }

    /// Coefficients of the cubic in s along f + s * d.
    [[nodiscard]] std::array<Value, 4> along(glm::dvec3 f, glm::dvec3 d) const
    {
        // Polynomials in s: x's and y's factors first, then z's.
        const auto quadratic = [&](std::size_t i) {
            const Value p0 = a[i] + a[i + 1] * f.x, p1 = a[i + 1] * d.x;
            const Value q0 = a[i + 2] + a[i + 3] * f.x, q1 = a[i + 3] * d.x;
            return std::array<Value, 3>{p0 + q0 * f.y, p1 + q1 * f.y + q0 * d.y, q1 * d.y};
        };
        const auto low = quadratic(0), high = quadratic(4);
        return {low[0] + high[0] * f.z, low[1] + high[1] * f.z + high[0] * d.z,
                low[2] + high[2] * f.z + high[1] * d.z, high[2] * d.z};
    }
};

template <class Tree>
using CellOf =
    Cell<std::conditional_t<std::is_same_v<typename Tree::ValueType, float>, double, glm::dvec3>>;

/// Clips [t0, t1] to where the ray is within a box; empty: t0 >= t1.
void clip(glm::dvec3 o, glm::dvec3 d, glm::dvec3 low, glm::dvec3 high, double& t0, double& t1)
{
    for (int axis = 0; axis < 3; ++axis) {
        if (d[axis] == 0) {
            if (o[axis] < low[axis] || o[axis] > high[axis])
                t1 = t0;
            continue;
        }
        const double a = (low[axis] - o[axis]) / d[axis], b = (high[axis] - o[axis]) / d[axis];
        t0 = std::max(t0, std::min(a, b));
        t1 = std::min(t1, std::max(a, b));
    }
}

/// Voxels along the edge of the empty block that a brick is in.
int empty_block(const Accessor<IndexTree>& accessor, const openvdb::Coord& brick)
{
    const int depth = accessor.getValueDepth(brick);
    return kBrickDim * (depth <= 0 ? 4096 : depth == 1 ? 128 : depth == 2 ? 8 : 1);
}

/// Calls enter(brick, number in the index) for every brick on the ray that may hold something, and
/// visit(cell, t0, t1) for the brick's cells, in order, until that answers false. Blocks of bricks
/// that are empty in the index are passed at once.
template <class Enter, class Visit>
void walk(const IndexTree& index, glm::dvec3 o, glm::dvec3 d, double t, double end,
          const Enter& enter, const Visit& visit)
{
    const Accessor<IndexTree> accessor(index);
    const glm::ivec3 step(d.x > 0 ? 1 : -1, d.y > 0 ? 1 : -1, d.z > 0 ? 1 : -1);
    const glm::ivec3 ahead(d.x > 0 ? 1 : 0, d.y > 0 ? 1 : 0, d.z > 0 ? 1 : 0);
    const glm::dvec3 inverse = 1.0 / d;
    glm::ivec3 cell(glm::floor(o + d * t));

    // Where the ray meets the next plane of an axis.
    const auto plane = [&](int axis, int at) {
        return d[axis] == 0 ? kInfinity : (static_cast<double>(at) - o[axis]) * inverse[axis];
    };
    const auto nearest = [](const std::array<double, 3>& at) {
        return at[0] < at[1] ? (at[0] < at[2] ? 0 : 2) : (at[1] < at[2] ? 1 : 2);
    };

    while (t < end) {
        const glm::ivec3 brick = cell >> 3;
        const openvdb::Coord coord = to_coord(brick);
        const std::int32_t number = accessor.getValue(coord);
        if (number == kEmptyBrick) {
            const int size = empty_block(accessor, coord);
            const glm::ivec3 low = cell & -size;
            std::array<double, 3> exits;
            for (int axis = 0; axis < 3; ++axis)
                exits[static_cast<std::size_t>(axis)] = plane(axis, low[axis] + size * ahead[axis]);
            const int side = nearest(exits);
            t = std::max(t, exits[static_cast<std::size_t>(side)]);
            if (!(t < end))
                return;
            cell = glm::clamp(glm::ivec3(glm::floor(o + d * t)), low, low + (size - 1));
            cell[side] = step[side] > 0 ? low[side] + size : low[side] - 1;
            continue;
        }
        enter(brick, number);
        std::array<double, 3> next;
        for (int axis = 0; axis < 3; ++axis)
            next[static_cast<std::size_t>(axis)] = plane(axis, cell[axis] + ahead[axis]);
        for (bool inside = true; inside && t < end;) {
            const int side = nearest(next);
            const double exit = std::min(next[static_cast<std::size_t>(side)], end);
            if (exit > t && !visit(cell, t, exit))
                return;
            t = std::max(t, exit);
            cell[side] += step[side];
            next[static_cast<std::size_t>(side)] = plane(side, cell[side] + ahead[side]);
            inside = cell[side] >> 3 == brick[side];
        }
    }
}

}  // namespace

struct VdbSampler::Impl {
    std::variant<std::unique_ptr<ScalarTree>, std::unique_ptr<VectorTree>> tree;
    IndexTree index{kEmptyBrick};
    std::vector<PaddedBrick> padded;
    glm::dvec3 low{1}, high{0};

    /// Calls visit(cell's polynomial, point in the cell, t0, t1).
    template <class Visit>
    void walk_cells(glm::dvec3 o, glm::dvec3 d, double t0, double t1, const Visit& visit) const
    {
        if (glm::any(glm::greaterThan(low, high)))
            return;
        clip(o, d, low, high, t0, t1);
        if (!(t0 < t1))
            return;
        std::visit(
            [&]<class Tree>(const std::unique_ptr<Tree>& held) {
                const Accessor<Tree> accessor(*held);
                CellOf<Tree> cell;
                const PaddedBrick* brick = nullptr;
                glm::ivec3 first(0);
                const auto enter = [&](glm::ivec3 at, std::int32_t number) {
                    brick = number > 0 ? &padded[static_cast<std::size_t>(number - 1)] : nullptr;
                    first = at * kBrickDim;
                };
                walk(index, o, d, t0, t1, enter, [&](glm::ivec3 at, double begin, double end) {
                    if (brick != nullptr)
                        cell.fetch(*brick, at - first);
                    else
                        cell.fetch(accessor, at);
                    return visit(cell, o + d * begin - glm::dvec3(at), begin, end);
                });
            },
            tree);
    }
};

VdbSampler::VdbSampler(const VoxelGrid& grid) : impl_(std::make_unique<Impl>())
{
    if (grid.channels == 1) {
        auto tree = build<ScalarTree>(grid, impl_->index);
        impl_->padded = pad(*tree, grid, impl_->index);
        impl_->tree = std::move(tree);
    } else {
        impl_->tree = build<VectorTree>(grid, impl_->index);
    }
    if (!grid.empty()) {
        impl_->low = glm::dvec3(grid.index_min) - 1.0;
        impl_->high = glm::dvec3(grid.index_max) + 1.0;
    }
}

VdbSampler::~VdbSampler() = default;
VdbSampler::VdbSampler(VdbSampler&&) noexcept = default;
VdbSampler& VdbSampler::operator=(VdbSampler&&) noexcept = default;

VdbSampler VdbSampler::open(const std::filesystem::path& file, const std::string& name)
{
    return VdbSampler(load_grid(file, name).grid);
}

bool VdbSampler::empty() const
{
    return impl_->low.x > impl_->high.x;
}

glm::dvec3 VdbSampler::sample(glm::dvec3 p) const
{
    if (!(glm::all(glm::greaterThan(p, impl_->low)) && glm::all(glm::lessThan(p, impl_->high))))
        return glm::dvec3(0);
    return std::visit(
        [&]<class Tree>(const std::unique_ptr<Tree>& tree) {
            const Accessor<Tree> accessor(*tree);
            return glm::dvec3([&] {
                const auto v = openvdb::tools::BoxSampler::sample(accessor, {p.x, p.y, p.z});
                if constexpr (std::is_same_v<typename Tree::ValueType, float>)
                    return glm::dvec3(v);
                else
                    return glm::dvec3(v[0], v[1], v[2]);
            }());
        },
        impl_->tree);
}

glm::dvec3 VdbSampler::value(glm::dvec3 p) const
{
    if (!(glm::all(glm::greaterThan(p, impl_->low)) && glm::all(glm::lessThan(p, impl_->high))))
        return glm::dvec3(0);
    const glm::ivec3 at(glm::floor(p)), brick = at >> 3;
    const std::int32_t number = impl_->index.root().getValue(to_coord(brick));
    if (number == kEmptyBrick)
        return glm::dvec3(0);
    return std::visit(
        [&]<class Tree>(const std::unique_ptr<Tree>& tree) {
            CellOf<Tree> cell;
            if (number > 0)
                cell.fetch(impl_->padded[static_cast<std::size_t>(number - 1)],
                           at - brick * kBrickDim);
            else
                cell.fetch(Accessor<Tree>(*tree), at);
            return glm::dvec3(cell.at(p - glm::dvec3(at)));
        },
        impl_->tree);
}

void VdbSampler::spans(glm::dvec3 origin, glm::dvec3 direction, double begin, double end,
                       double most, std::vector<Span>& out) const
{
    glm::dvec3 sum(0);
    impl_->walk_cells(
        origin, direction, begin, end, [&](const auto& cell, glm::dvec3 f, double t0, double t1) {
            const auto c = cell.along(f, direction);
            out.push_back(
                {t0, t1, {glm::dvec3(c[0]), glm::dvec3(c[1]), glm::dvec3(c[2]), glm::dvec3(c[3])}});
            sum += glm::dvec3(cell.integral(f, direction, t1 - t0));
            return std::min({sum.x, sum.y, sum.z}) <= most;
        });
}

glm::dvec3 VdbSampler::column(glm::dvec3 origin, glm::dvec3 direction, double begin, double end,
                              double most) const
{
    glm::dvec3 sum(0);
    std::visit(
        [&]<class Tree>(const std::unique_ptr<Tree>&) {
            typename CellOf<Tree>::Number total(0);
            impl_->walk_cells(
                origin, direction, begin, end,
                [&](const auto& cell, glm::dvec3 f, double t0, double t1) {
                    if constexpr (std::is_same_v<std::decay_t<decltype(cell)>, CellOf<Tree>>)
                        total += cell.integral(f, direction, t1 - t0);
                    if constexpr (std::is_same_v<decltype(total), double>)
                        return total <= most;
                    else
                        return std::min({total.x, total.y, total.z}) <= most;
                });
            sum = glm::dvec3(total);
        },
        impl_->tree);
    return sum;
}

}  // namespace fumarole::asset
