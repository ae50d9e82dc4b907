#include "medium/glow_cells.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <tbb/parallel_for.h>

namespace fumarole::medium {

namespace {

constexpr int kLongest = 16;  // cells along the longest edge
constexpr int kSamples = 2;   // along each axis of a cell

/// A cell of those of a lattice.
struct Cells {
    glm::ivec3 count;

    [[nodiscard]] bool holds(glm::ivec3 at) const
    {
        return glm::all(glm::greaterThanEqual(at, glm::ivec3(0))) &&
               glm::all(glm::lessThan(at, count));
    }
    [[nodiscard]] std::size_t index(glm::ivec3 at) const
    {
        return static_cast<std::size_t>((at.z * count.y + at.y) * count.x + at.x);
    }
    [[nodiscard]] glm::ivec3 at(std::size_t index) const
    {
        const auto i = static_cast<int>(index);
        return {i % count.x, i / count.x % count.y, i / (count.x * count.y)};
    }
};

/// Optical depth from each cell's middle to beyond all cells, from cell to cell that way.
std::vector<glm::dvec3> depths_along(const GlowCells& cells, glm::ivec3 way, double metres)
{
    const Cells all{cells.count};
    const std::size_t number = cells.sigma_t.size();
    std::vector<glm::dvec3> depths(number);
    // The last cell first wherever a way goes on to a later one.
    const bool backwards = all.index(way + 1) > all.index(glm::ivec3(1));
    for (std::size_t i = 0; i < number; ++i) {
        const std::size_t here = backwards ? number - 1 - i : i;
        const glm::ivec3 next = all.at(here) + way;
        depths[here] = 0.5 * metres * cells.sigma_t[here];
        if (all.holds(next))
            depths[here] += 0.5 * metres * cells.sigma_t[all.index(next)] + depths[all.index(next)];
    }
    return depths;
}

/// Trilinear between the cells' middles.
glm::dvec3 between(const std::vector<glm::dvec3>& values, glm::ivec3 count, glm::dvec3 place)
{
    const Cells all{count};
    const glm::dvec3 p = glm::clamp(place - 0.5, glm::dvec3(0), glm::dvec3(count - 1));
    const glm::ivec3 low = glm::min(glm::ivec3(p), glm::max(count - 2, 0));
    const glm::dvec3 f = p - glm::dvec3(low);
    glm::dvec3 sum(0);
    for (int i = 0; i < 8; ++i) {
        const glm::ivec3 step(i & 1, (i >> 1) & 1, i >> 2);
        const glm::dvec3 weights = glm::mix(1.0 - f, f, glm::dvec3(step));
        sum +=
            weights.x * weights.y * weights.z * values[all.index(glm::min(low + step, count - 1))];
    }
    return sum;
}

}  // namespace

glm::dvec3 GlowCells::escapes(std::span<const glm::dvec3> places) const
{
    if (empty() || places.empty())
        return glm::dvec3(1);
    glm::dvec3 all(0);
    for (const glm::dvec3& one : power)
        all += one;
    const glm::dvec3 edges = (bounds.max - bounds.min) / glm::dvec3(count);
    glm::dvec3 out(0), from_places(0);
    for (int i = 0; i < 27; ++i) {
        const glm::ivec3 way = glm::ivec3(i % 3, i / 3 % 3, i / 9) - 1;
        if (way == glm::ivec3(0))
            continue;
        const auto depths = depths_along(*this, way, glm::length(edges * glm::dvec3(way)));
        for (std::size_t cell = 0; cell < power.size(); ++cell)
            out += power[cell] * glm::exp(-depths[cell]);
        for (const glm::dvec3& place : places)
            from_places += glm::exp(-between(depths, count, (place - bounds.min) / edges));
    }
    from_places *= all / static_cast<double>(places.size());
    glm::dvec3 ratio(1);
    for (int c = 0; c < 3; ++c)
        if (from_places[c] > 0)
            ratio[c] = out[c] / from_places[c];
    return ratio;
}

GlowCells glow_cells(const Bounds& bounds, const std::function<glm::dvec3(glm::dvec3)>& radiance,
                     const std::function<glm::dvec3(glm::dvec3)>& sigma_t)
{
    GlowCells cells;
    cells.bounds = bounds;
    const glm::dvec3 size = bounds.max - bounds.min;
    if (!(size.x * size.y * size.z > 0))
        return cells;  // a box without a volume glows nothing
    const double edge = std::max({size.x, size.y, size.z}) / kLongest;
    cells.count = glm::max(glm::ivec3(glm::ceil(size / edge - 1e-6)), 1);
    const Cells all{cells.count};
    const glm::dvec3 edges = size / glm::dvec3(cells.count);
    const double volume = edges.x * edges.y * edges.z;
    const auto number = static_cast<std::size_t>(cells.count.x) * cells.count.y * cells.count.z;
    cells.power.resize(number);
    cells.sigma_t.resize(number);
    tbb::parallel_for(std::size_t{0}, number, [&](std::size_t cell) {
        constexpr int kEach = kSamples * kSamples * kSamples;
        glm::dvec3 sent(0), dims(0);
        for (int i = 0; i < kEach; ++i) {
            const glm::ivec3 part(i % kSamples, i / kSamples % kSamples, i / (kSamples * kSamples));
            const glm::dvec3 at =
                bounds.min +
                edges * (glm::dvec3(all.at(cell)) + (glm::dvec3(part) + 0.5) / double(kSamples));
            sent += radiance(at);
            dims += sigma_t(at);
        }
        cells.power[cell] = sent * (volume / kEach);
        cells.sigma_t[cell] = dims / double(kEach);
    });
    return cells;
}

}  // namespace fumarole::medium
