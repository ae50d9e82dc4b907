#include "asset/vdb_sampler.h"

#include <cmath>
#include <limits>
#include <openvdb/Types.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tree/Tree.h>
#include <openvdb/tree/ValueAccessor.h>
#include <variant>

#include "asset/vdb_file.h"

namespace fumarole::asset {

namespace {

template <class T> using TreeOf = typename openvdb::tree::Tree4<T, 5, 4, 3>::Type;
using ScalarTree = TreeOf<float>;
using VectorTree = TreeOf<openvdb::Vec3f>;
using MaskTree = TreeOf<bool>;
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

template <class Tree> std::unique_ptr<Tree> build(const VoxelGrid& grid, MaskTree& cells)
{
    using T = typename Tree::ValueType;
    auto tree = std::make_unique<Tree>(T(0));
    const auto touch = [&](glm::ivec3 first_brick, glm::ivec3 last_brick) {
        // A cell reaches one voxel on, so a brick's values fill cells of the bricks before it too.
        cells.fill({to_coord((first_brick - 1) * kBrickDim),
                    to_coord(last_brick * kBrickDim + (kBrickDim - 1))},
                   true, true);
    };
    for (const VoxelTile& tile : grid.tiles) {
        T value;
        if constexpr (std::is_same_v<T, float>)
            value = tile.value.x;
        else
            value = T(tile.value.x, tile.value.y, tile.value.z);
        tree->fill({to_coord(tile.brick_min * kBrickDim),
                    to_coord(tile.brick_max * kBrickDim + (kBrickDim - 1))},
                   value, true);
        touch(tile.brick_min, tile.brick_max);
    }
    for (std::size_t b = 0; b < grid.bricks.size(); ++b) {
        auto* leaf = tree->touchLeaf(to_coord(grid.bricks[b] * kBrickDim));
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

/// Calls visit(cell, t0, t1) for every cell on the ray that may hold something, in order, until it
/// answers false. Blocks of 8, 128 and 4096 cells that are empty in the mask are passed at once.
template <class Visit>
void walk(const MaskTree& mask, glm::dvec3 o, glm::dvec3 d, double t, double end,
          const Visit& visit)
{
    const Accessor<MaskTree> accessor(mask);
    const glm::ivec3 step(d.x > 0 ? 1 : -1, d.y > 0 ? 1 : -1, d.z > 0 ? 1 : -1);
    const glm::dvec3 inverse = 1.0 / d;
    glm::ivec3 cell(glm::floor(o + d * t));

    // Where the ray leaves the block [low, low + size), and through which side.
    const auto leave = [&](glm::ivec3 low, int size, int& side) {
        double exit = kInfinity;
        side = 0;
        for (int axis = 0; axis < 3; ++axis) {
            if (d[axis] == 0)
                continue;
            const double plane =
                static_cast<double>(low[axis]) + (step[axis] > 0 ? static_cast<double>(size) : 0.0);
            const double at = (plane - o[axis]) * inverse[axis];
            if (at < exit) {
                exit = at;
                side = axis;
            }
        }
        return exit;
    };

    while (t < end) {
        const openvdb::Coord coord = to_coord(cell);
        if (!accessor.isValueOn(coord)) {
            const int depth = accessor.getValueDepth(coord);
            const int size = depth <= 0 ? 4096 : (depth == 1 ? 128 : kBrickDim);
            const glm::ivec3 low = cell & -size;
            int side = 0;
            t = std::max(t, leave(low, size, side));
            if (!(t < end))
                return;
            cell = glm::clamp(glm::ivec3(glm::floor(o + d * t)), low, low + (size - 1));
            cell[side] = step[side] > 0 ? low[side] + size : low[side] - 1;
            continue;
        }
        const glm::ivec3 brick = cell & -kBrickDim;
        while ((cell & -kBrickDim) == brick && t < end) {
            int side = 0;
            const double exit = std::min(leave(cell, 1, side), end);
            if (exit > t && !visit(cell, t, exit))
                return;
            t = std::max(t, exit);
            cell[side] += step[side];
        }
    }
}

}  // namespace

struct VdbSampler::Impl {
    std::variant<std::unique_ptr<ScalarTree>, std::unique_ptr<VectorTree>> tree;
    MaskTree cells{false};  ///< bricks of cells that may hold more than 0
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
                walk(cells, o, d, t0, t1, [&](glm::ivec3 index, double begin, double end) {
                    cell.fetch(accessor, index);
                    return visit(cell, o + d * begin - glm::dvec3(index), begin, end);
                });
            },
            tree);
    }
};

VdbSampler::VdbSampler(const VoxelGrid& grid) : impl_(std::make_unique<Impl>())
{
    if (grid.channels == 1)
        impl_->tree = build<ScalarTree>(grid, impl_->cells);
    else
        impl_->tree = build<VectorTree>(grid, impl_->cells);
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

void VdbSampler::for_each_filled(const std::function<void(glm::ivec3, glm::ivec3)>& visit) const
{
    std::visit(
        [&]<class Tree>(const std::unique_ptr<Tree>& tree) {
            for (auto it = tree->cbeginValueOn(); it; ++it) {
                if (*it == typename Tree::ValueType(0))
                    continue;
                openvdb::CoordBBox box;
                it.getBoundingBox(box);
                visit({box.min().x(), box.min().y(), box.min().z()},
                      {box.max().x(), box.max().y(), box.max().z()});
            }
        },
        impl_->tree);
}

}  // namespace fumarole::asset
