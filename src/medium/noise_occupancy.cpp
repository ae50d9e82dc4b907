#include "medium/noise_occupancy.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <tbb/parallel_for.h>

#include "noise_gradient.h"

namespace fumarole::medium {

namespace {

// Noise in a cell is the sum over its corners of weight * dot(gradient, offset), and each corner's
// gradient is one of 12, so what it can be at most at a place is the sum of the corners' largest
// terms: a function of the place alone. Likewise its second derivative along an axis, to which the
// weight's second and first derivatives add: fade'' * dot(gradient, offset) + 2 fade' * gradient.
// Their largest values over a cell, scanned in steps of 1 / 200: 1.0364 at (0.36, 0.5, 0.48), and
// 12.04 at (0.26, 0.5, 0.45). Both derivatives of the fade are 0 at 0 and 1: it bends no more
// across cells.
constexpr double kMostNoise = 1.04;
constexpr double kMostBend = 12.1;  ///< per cell^2
/// Of the octaves' sum: the GPU works places out in single precision, from the eye.
constexpr double kRounding = 1e-3;

/// Blocks of bounds, and nodes at which the noise is sampled: kCells + 1 along each of their edges.
struct Nodes {
    static constexpr int kCells = 3;
    glm::ivec3 blocks{1};
    glm::dvec3 spacing{0};  ///< metres

    Nodes(const Bounds& bounds, double least)
    {
        const glm::dvec3 extent = bounds.max - bounds.min;
        blocks = glm::max(glm::ivec3(glm::ceil(extent / (least * kCells) - 1e-6)), glm::ivec3(1));
        spacing = extent / glm::dvec3(blocks * kCells);
    }
    [[nodiscard]] glm::ivec3 count() const { return blocks * kCells + 1; }
};

/// As fine as the last octave asks, or as a time of some milliseconds allows.
Nodes place_nodes(const NoiseProfile& noise, const Bounds& bounds)
{
    constexpr double kMostNodes = 1.2e6;
    constexpr double kNodesPerCell = 8;
    const double finest = noise.feature_size / std::pow(noise.lacunarity, noise.octaves - 1);
    const glm::dvec3 extent = bounds.max - bounds.min;
    const double longest = std::max({extent.x, extent.y, extent.z});
    for (double spacing = std::max(finest / kNodesPerCell, longest / kMostNodes);; spacing *= 1.1) {
        const glm::dvec3 many = glm::ceil(extent / spacing) + double{Nodes::kCells};
        if (many.x * many.y * many.z <= kMostNodes)
            return {bounds, spacing};
    }
}

/// The places of nodes along an axis, in an octave's cells.
struct AxisNodes {
    struct Node {
        int cell = 0;  ///< from the axis' first
        float f = 0, u = 0;
    };
    std::int64_t first = 0;
    std::vector<Node> nodes;

    AxisNodes(double begin, double spacing, int count)
        : first{static_cast<std::int64_t>(std::floor(begin))}
    {
        for (int i = 0; i < count; ++i) {
            const double q = begin + spacing * i, whole = std::floor(q);
            const auto f = static_cast<float>(q - whole);
            nodes.push_back(
                {static_cast<int>(static_cast<std::int64_t>(whole) - first), f, noise_fade(f)});
        }
    }
    /// Points of the lattice on either side of the nodes.
    [[nodiscard]] int points() const { return nodes.back().cell + 2; }
};

/// One octave at the nodes.
class OctaveNodes {
public:
    OctaveNodes(const Bounds& bounds, const Nodes& nodes, double frequency, double amplitude,
                std::uint32_t seed)
        : amplitude_{static_cast<float>(amplitude)}
    {
        for (int a = 0; a < 3; ++a)
            axes_.emplace_back(bounds.min[a] * frequency, nodes.spacing[a] * frequency,
                               nodes.count()[a]);
        for (int z = 0; z < axes_[2].points(); ++z)
            for (int y = 0; y < axes_[1].points(); ++y)
                for (int x = 0; x < axes_[0].points(); ++x)
                    gradients_.push_back(
                        noise_gradient({static_cast<std::uint32_t>(axes_[0].first + x),
                                        static_cast<std::uint32_t>(axes_[1].first + y),
                                        static_cast<std::uint32_t>(axes_[2].first + z)},
                                       seed));
    }

    /// Adds its part to the sums of the row of nodes at y, z.
    void add_row(int y, int z, std::vector<float>& sums) const
    {
        const AxisNodes::Node &ny = axes_[1].nodes[static_cast<std::size_t>(y)],
                              &nz = axes_[2].nodes[static_cast<std::size_t>(z)];
        const std::vector<Line> lines = lines_along(ny, nz);
        for (std::size_t i = 0; i < sums.size(); ++i) {
            const AxisNodes::Node& n = axes_[0].nodes[i];
            const Line &l = lines[static_cast<std::size_t>(n.cell)],
                       &r = lines[static_cast<std::size_t>(n.cell) + 1];
            const float left = l.at + l.slope * n.f, right = r.at + r.slope * (n.f - 1.0f);
            sums[i] += amplitude_ * (left + n.u * (right - left));
        }
    }

private:
    /// What the four gradients of one x add up to, linear in the distance along x.
    struct Line {
        float at = 0, slope = 0;
    };
    [[nodiscard]] std::vector<Line> lines_along(const AxisNodes::Node& y,
                                                const AxisNodes::Node& z) const
    {
        const auto columns = static_cast<std::size_t>(axes_[0].points()),
                   rows = static_cast<std::size_t>(axes_[1].points());
        std::vector<Line> lines(columns);
        for (int i = 0; i < 4; ++i) {
            const int dy = i & 1, dz = i >> 1;
            const float weight = (dy != 0 ? y.u : 1.0f - y.u) * (dz != 0 ? z.u : 1.0f - z.u);
            const glm::vec3* row = &gradients_[(static_cast<std::size_t>(z.cell + dz) * rows +
                                                static_cast<std::size_t>(y.cell + dy)) *
                                               columns];
            const float oy = y.f - static_cast<float>(dy), oz = z.f - static_cast<float>(dz);
            for (std::size_t x = 0; x < columns; ++x) {
                lines[x].at += weight * (row[x].y * oy + row[x].z * oz);
                lines[x].slope += weight * row[x].x;
            }
        }
        return lines;
    }

    float amplitude_;
    std::vector<AxisNodes> axes_;
    std::vector<glm::vec3> gradients_;  ///< of the lattice's points, x fastest
};

/// Numbers of a grid of blocks, x fastest.
struct Blocks {
    glm::ivec3 count{0};
    std::vector<float> values;

    explicit Blocks(glm::ivec3 n)
        : count{n}, values(static_cast<std::size_t>(n.x) * static_cast<std::size_t>(n.y) *
                               static_cast<std::size_t>(n.z),
                           -std::numeric_limits<float>::infinity())
    {
    }
    [[nodiscard]] float& at(int x, int y, int z)
    {
        return values[(static_cast<std::size_t>(z) * static_cast<std::size_t>(count.y) +
                       static_cast<std::size_t>(y)) *
                          static_cast<std::size_t>(count.x) +
                      static_cast<std::size_t>(x)];
    }
    /// The part of them that is not empty, 0..1.
    [[nodiscard]] float filled() const
    {
        const auto many =
            std::count_if(values.begin(), values.end(), [](float value) { return value > 0; });
        return static_cast<float>(many) / static_cast<float>(values.size());
    }
};

/// The largest sum of the octaves at the nodes of each block, those on its faces too.
Blocks largest_sums(const std::vector<OctaveNodes>& octaves, const Nodes& nodes)
{
    const glm::ivec3 count = nodes.count();
    Blocks planes({nodes.blocks.x, nodes.blocks.y, count.z});
    constexpr int kCells = Nodes::kCells;
    tbb::parallel_for(0, count.z, [&](int z) {
        std::vector<float> sums(static_cast<std::size_t>(count.x));
        for (int y = 0; y < count.y; ++y) {
            std::fill(sums.begin(), sums.end(), 0.0f);
            for (const OctaveNodes& octave : octaves)
                octave.add_row(y, z, sums);
            const int last = std::min(y / kCells, nodes.blocks.y - 1);
            for (int x = 0; x < nodes.blocks.x; ++x) {
                const float largest = *std::max_element(sums.begin() + x * kCells,
                                                        sums.begin() + (x + 1) * kCells + 1);
                for (int block = std::max((y - 1) / kCells, 0); block <= last; ++block)
                    planes.at(x, block, z) = std::max(planes.at(x, block, z), largest);
            }
        }
    });
    Blocks largest(nodes.blocks);
    for (int z = 0; z < count.z; ++z)
        for (int block = std::max((z - 1) / kCells, 0);
             block <= std::min(z / kCells, nodes.blocks.z - 1); ++block)
            for (int y = 0; y < nodes.blocks.y; ++y)
                for (int x = 0; x < nodes.blocks.x; ++x)
                    largest.at(x, y, block) = std::max(largest.at(x, y, block), planes.at(x, y, z));
    return largest;
}

/// An upper bound of the coefficient in each block.
Blocks bound_blocks(const NoiseProfile& noise, const Bounds& bounds, const Nodes& nodes)
{
    std::vector<OctaveNodes> octaves;
    double between = kRounding;  // more than at any node
    double amplitude = 1, amplitudes = 0, frequency = 1 / noise.feature_size;
    for (int i = 0; i < noise.octaves; ++i) {
        // Of a function that bends by b at most, the line through two of its points a distance of h
        // apart errs by h^2 b / 8, and lies under the higher one.
        const double bends =
            kMostBend / 8 * glm::dot(nodes.spacing, nodes.spacing) * frequency * frequency;
        if (bends < kMostNoise)
            octaves.emplace_back(bounds, nodes, frequency, amplitude,
                                 noise_octave_seed(noise.seed, i));
        between += amplitude * std::min(bends, kMostNoise);
        amplitudes += amplitude;
        amplitude *= noise.gain;
        frequency *= noise.lacunarity;
    }
    Blocks blocks = largest_sums(octaves, nodes);
    for (float& value : blocks.values) {
        const double fbm = 0.5 + 0.5 * (static_cast<double>(value) + between) / amplitudes;
        value = static_cast<float>(std::max(0.0, (fbm - noise.threshold) / (1 - noise.threshold)));
    }
    return blocks;
}

/// Each eight blocks as one.
Blocks halved(Blocks& blocks)
{
    Blocks half((blocks.count + 1) / 2);
    for (int z = 0; z < blocks.count.z; ++z)
        for (int y = 0; y < blocks.count.y; ++y)
            for (int x = 0; x < blocks.count.x; ++x)
                half.at(x / 2, y / 2, z / 2) =
                    std::max(half.at(x / 2, y / 2, z / 2), blocks.at(x, y, z));
    return half;
}

/// A run of blocks from `first`, up to `longest` along each axis, that are not empty; they are
/// then.
glm::ivec3 take_run(Blocks& blocks, glm::ivec3 first, int longest, float& most)
{
    const auto all = [&](glm::ivec3 begin, glm::ivec3 end, auto f) {
        for (int z = begin.z; z < end.z; ++z)
            for (int y = begin.y; y < end.y; ++y)
                for (int x = begin.x; x < end.x; ++x)
                    if (!f(blocks.at(x, y, z)))
                        return false;
        return true;
    };
    glm::ivec3 end = first + 1;
    for (int axis = 0; axis < 3; ++axis)
        while (end[axis] < std::min(first[axis] + longest, blocks.count[axis])) {
            glm::ivec3 next = first, beyond = end;
            next[axis] = end[axis];
            beyond[axis] = end[axis] + 1;
            if (!all(next, beyond, [](float value) { return value > 0; }))
                break;
            end = beyond;
        }
    all(first, end, [&](float& value) {
        most = std::max(most, value);
        value = 0;
        return true;
    });
    return end;
}

/// Long boxes would be few, but seen at a slant each reaches over much that is empty.
std::vector<OccupiedBox> join(Blocks blocks, const Bounds& bounds, glm::dvec3 edge)
{
    constexpr int kLongest = 8;
    std::vector<OccupiedBox> boxes;
    for (int z = 0; z < blocks.count.z; ++z)
        for (int y = 0; y < blocks.count.y; ++y)
            for (int x = 0; x < blocks.count.x; ++x) {
                if (!(blocks.at(x, y, z) > 0))
                    continue;
                OccupiedBox box;
                const glm::ivec3 first(x, y, z);
                const glm::ivec3 end = take_run(blocks, first, kLongest, box.most);
                box.bounds = {bounds.min + glm::dvec3(first) * edge,
                              glm::min(bounds.min + glm::dvec3(end) * edge, bounds.max)};
                boxes.push_back(box);
            }
    return boxes;
}

}  // namespace

std::vector<OccupiedBox> occupied_boxes(const NoiseProfile& noise, const Bounds& bounds,
                                        std::size_t limit)
{
    constexpr float kWorthwhile = 0.75f;  // above that, boxes cost a frame more than they save
    const Nodes nodes = place_nodes(noise, bounds);
    Blocks blocks = bound_blocks(noise, bounds, nodes);
    if (blocks.filled() > kWorthwhile)
        return {{bounds, *std::max_element(blocks.values.begin(), blocks.values.end())}};
    for (double edge = Nodes::kCells;; edge *= 2, blocks = halved(blocks)) {
        std::vector<OccupiedBox> boxes = join(blocks, bounds, nodes.spacing * edge);
        if (boxes.size() <= limit)
            return boxes;
    }
}

}  // namespace fumarole::medium
