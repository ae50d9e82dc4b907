#include "medium/glow.h"

#include <algorithm>
#include <cmath>
#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

namespace fumarole::medium {

namespace {

/// Sums over places, weighed by what each sends.
struct Moments {
    glm::dvec3 power{0}, sigma_t{0}, first{0};
    glm::dmat3 second{0.0};
    double weight = 0;

    void add(glm::dvec3 sent, glm::dvec3 at, glm::dvec3 extinction)
    {
        const double w = sent.r + sent.g + sent.b;
        power += sent;
        weight += w;
        first += w * at;
        sigma_t += w * extinction;
        second += w * glm::outerProduct(at, at);
    }
    Moments operator+(const Moments& other) const
    {
        Moments sum = *this;
        sum.power += other.power;
        sum.sigma_t += other.sigma_t;
        sum.first += other.first;
        sum.second += other.second;
        sum.weight += other.weight;
        return sum;
    }
    [[nodiscard]] Glow glow() const
    {
        Glow out;
        if (!(weight > 0))
            return out;
        out.power = power;
        out.middle = first / weight;
        out.spread = second / weight - glm::outerProduct(out.middle, out.middle);
        out.sigma_t = sigma_t / weight;
        return out;
    }
};

/// Of something even that is a box of these edges.
glm::dmat3 spread_of_box(glm::dvec3 edges)
{
    glm::dmat3 spread(0.0);
    for (int i = 0; i < 3; ++i)
        spread[i][i] = edges[i] * edges[i] / 12;
    return spread;
}

}  // namespace

Glow Glow::transformed(const glm::dmat4& world_from_own) const
{
    const glm::dmat3 turn(world_from_own);
    Glow out = *this;
    out.power *= std::abs(glm::determinant(turn));
    out.middle = glm::dvec3(world_from_own * glm::dvec4(middle, 1.0));
    out.spread = turn * spread * glm::transpose(turn);
    return out;
}

Glow together(const Glow& a, const Glow& b)
{
    const auto weight = [](const Glow& one) { return one.power.r + one.power.g + one.power.b; };
    const double sum = weight(a) + weight(b);
    if (!(sum > 0))
        return a;
    Glow out;
    out.power = a.power + b.power;
    out.middle = (weight(a) * a.middle + weight(b) * b.middle) / sum;
    for (const Glow* one : {&a, &b}) {
        const glm::dvec3 from = one->middle - out.middle;
        out.spread += (weight(*one) / sum) * (one->spread + glm::outerProduct(from, from));
        out.sigma_t += (weight(*one) / sum) * one->sigma_t;
    }
    return out;
}

// Jacobi's rotations (Golub and Van Loan 2013, "Matrix Computations", sec. 8.5).
Glow::Axes Glow::axes() const
{
    constexpr int kSweeps = 12;
    glm::dmat3 a = spread, turns(1.0);
    for (int sweep = 0; sweep < kSweeps; ++sweep)
        for (int p = 0; p < 2; ++p)
            for (int q = p + 1; q < 3; ++q) {
                if (std::abs(a[q][p]) <= 1e-15 * (std::abs(a[p][p]) + std::abs(a[q][q])))
                    continue;
                const double angle = 0.5 * std::atan2(2 * a[q][p], a[q][q] - a[p][p]);
                glm::dmat3 turn(1.0);
                turn[p][p] = turn[q][q] = std::cos(angle);
                turn[q][p] = std::sin(angle);
                turn[p][q] = -std::sin(angle);
                a = glm::transpose(turn) * a * turn;
                turns = turns * turn;
            }
    glm::ivec3 order(0, 1, 2);
    std::sort(&order.x, &order.x + 3, [&](int i, int j) { return a[i][i] > a[j][j]; });
    Axes out;
    for (int i = 0; i < 3; ++i) {
        out.edges[i] = std::sqrt(12 * std::max(a[order[i]][order[i]], 0.0));
        out.directions[i] = turns[order[i]];
    }
    return out;
}

Glow glow_of(const VoxelGrid& grid, const std::function<glm::dvec3(glm::dvec3)>& radiance,
             const std::function<glm::dvec3(glm::dvec3)>& sigma_t_at)
{
    constexpr int kDim = VoxelGrid::kBrickDim;
    const auto extinction_at = [&](glm::dvec3 at) {
        return sigma_t_at ? sigma_t_at(at) : glm::dvec3(0);
    };
    const auto channels = static_cast<std::size_t>(grid.channels);
    const auto of_brick = [&](std::size_t brick) {
        Moments sum;
        const float* value = grid.values.data() + brick * VoxelGrid::kBrickVoxels * channels;
        const glm::ivec3 first = kDim * grid.bricks[brick];
        for (int z = 0; z < kDim; ++z)
            for (int y = 0; y < kDim; ++y)
                for (int x = 0; x < kDim; ++x, value += channels) {
                    const glm::vec3 v =
                        channels == 1 ? glm::vec3(*value) : glm::vec3(value[0], value[1], value[2]);
                    if (v != glm::vec3(0))
                        sum.add(radiance(v), glm::dvec3(first + glm::ivec3(x, y, z)),
                                glm::dvec3(0));
                }
        // What a brick has in its middle is enough for an extinction.
        if (sum.weight > 0)
            sum.sigma_t = sum.weight * extinction_at(sum.first / sum.weight);
        return sum;
    };
    Moments sum = tbb::parallel_deterministic_reduce(
        tbb::blocked_range<std::size_t>(0, grid.bricks.size(), 64), Moments(),
        [&](const tbb::blocked_range<std::size_t>& range, Moments part) {
            for (std::size_t brick = range.begin(); brick < range.end(); ++brick)
                part = part + of_brick(brick);
            return part;
        },
        [](const Moments& a, const Moments& b) { return a + b; });
    for (const VoxelTile& tile : grid.tiles) {
        const glm::dvec3 voxels(kDim * (tile.brick_max - tile.brick_min + 1));
        const glm::dvec3 middle = glm::dvec3(kDim * tile.brick_min) + 0.5 * (voxels - 1.0);
        Moments part;
        const glm::vec3 value = grid.channels == 1 ? glm::vec3(tile.value.x) : tile.value;
        part.add(radiance(value) * (voxels.x * voxels.y * voxels.z), middle, extinction_at(middle));
        part.second += part.weight * spread_of_box(voxels);
        sum = sum + part;
    }
    Glow glow = sum.glow();
    // Between voxels it is linear, which spreads each over a tent.
    glow.spread += 2.0 * spread_of_box(glm::dvec3(1));
    return glow;
}

Glow glow_of(const Bounds& box, glm::dvec3 radiance, glm::dvec3 sigma_t,
             const std::function<double(double)>& profile)
{
    constexpr int kSlices = 64;
    const glm::dvec3 size = box.max - box.min;
    const glm::dvec3 slice(size.x, size.y, size.z / kSlices);
    Moments sum;
    for (int i = 0; i < kSlices; ++i) {
        const double z = box.min.z + slice.z * (i + 0.5);
        const double here = profile(z);
        const glm::dvec3 middle(0.5 * (box.min + box.max));
        sum.add(radiance * (here * slice.x * slice.y * slice.z), {middle.x, middle.y, z},
                sigma_t * here);
    }
    Glow glow = sum.glow();
    glow.spread += spread_of_box(slice);
    return glow;
}

}  // namespace fumarole::medium
