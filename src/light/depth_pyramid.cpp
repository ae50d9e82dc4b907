#include "light/depth_pyramid.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <tbb/parallel_for.h>

namespace fumarole::light {

namespace {

constexpr DepthPyramid::Extent kNone{std::numeric_limits<float>::infinity(),
                                     -std::numeric_limits<float>::infinity()};

DepthPyramid::Extent both(DepthPyramid::Extent a, DepthPyramid::Extent b)
{
    return {std::min(a.least, b.least), std::max(a.most, b.most)};
}

std::size_t at(int x, int y, int edge)
{
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(edge) +
           static_cast<std::size_t>(x);
}

}  // namespace

DepthPyramid::DepthPyramid(std::span<const float> texels, int size) : size_{size}
{
    assert(texels.size() == static_cast<std::size_t>(size) * static_cast<std::size_t>(size));
    Level level{.edge = (size + kBlock - 1) / kBlock, .blocks = {}};
    level.blocks.assign(at(0, level.edge, level.edge), kNone);
    tbb::parallel_for(0, level.edge, [&](int block_y) {
        for (int y = block_y * kBlock; y < std::min(size, (block_y + 1) * kBlock); ++y)
            for (int x = 0; x < size; ++x) {
                Extent& block = level.blocks[at(x / kBlock, block_y, level.edge)];
                const float depth = texels[at(x, y, size)];
                block = both(block, {depth, depth});
            }
    });
    levels_.push_back(std::move(level));
    while (levels_.back().edge > 1) {
        const Level& fine = levels_.back();
        Level coarse{.edge = (fine.edge + 1) / 2, .blocks = {}};
        coarse.blocks.assign(at(0, coarse.edge, coarse.edge), kNone);
        for (int y = 0; y < fine.edge; ++y)
            for (int x = 0; x < fine.edge; ++x) {
                Extent& block = coarse.blocks[at(x / 2, y / 2, coarse.edge)];
                block = both(block, fine.blocks[at(x, y, fine.edge)]);
            }
        levels_.push_back(std::move(coarse));
    }
}

DepthPyramid::Extent DepthPyramid::over(glm::dvec2 low, glm::dvec2 high) const
{
    // A lookup reads the texels whose middles are up to one texel off; the half beyond that is for
    // what the GPU rounds.
    const auto block_of = [&](glm::dvec2 uv, double slack) {
        const glm::dvec2 block = glm::floor((uv * double(size_) + slack) / double{kBlock});
        return glm::ivec2(glm::clamp(block, glm::dvec2(0), glm::dvec2(levels_[0].edge - 1)));
    };
    glm::ivec2 first = block_of(low, -1.5), last = block_of(high, 1.5);
    constexpr int kAcross =
        3;  // blocks: tighter than the usual two, for the price of a few lookups
    std::size_t level = 0;
    while (last.x - first.x >= kAcross || last.y - first.y >= kAcross) {
        first /= 2;
        last /= 2;
        ++level;
    }
    Extent extent = kNone;
    for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x)
            extent = both(extent, levels_[level].blocks[at(x, y, levels_[level].edge)]);
    return extent;
}

}  // namespace fumarole::light
