#include "light/nodes_near_surfaces.h"

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>

#include "shared/field_nodes.h"
#include "shared/light_volume_params.h"

namespace fumarole::light {

namespace {

/// A place is looked up half a node above the surface, and again one more above that or beside it,
/// between the eight nodes around each: 2.5 nodes away at most.
constexpr double kReach = 3;
/// Those of a solid are looked up from its outside: half a node behind its face at most.
constexpr double kDepth = 1;

struct Range {
    glm::ivec3 first{0}, end{0};
    [[nodiscard]] bool holds(glm::ivec3 node) const
    {
        return glm::all(glm::greaterThanEqual(node, first)) && glm::all(glm::lessThan(node, end));
    }
};

/// Nodes whose places are at least `low` and at most `high`.
Range nodes_from(glm::dvec3 low, glm::dvec3 high, glm::ivec3 count)
{
    const glm::dvec3 all(count);
    return {glm::ivec3(glm::clamp(glm::ceil(low), glm::dvec3(0), all)),
            glm::ivec3(glm::clamp(glm::floor(high) + 1.0, glm::dvec3(0), all))};
}

/// Nodes around the faces of the box that lies within a lattice by SURFACES_RIM of its edges.
void add_rim(std::vector<char>& is_near, glm::ivec3 count)
{
    const glm::dvec3 last(count - 1), rim = double{SURFACES_RIM} * last;
    const Range around = nodes_from(rim - 1.0, last - rim + 1.0, count);
    const Range within = nodes_from(rim + 1.0, last - rim - 1.0, count);
    std::size_t i = 0;
    for (int z = 0; z < count.z; ++z)
        for (int y = 0; y < count.y; ++y)
            for (int x = 0; x < count.x; ++x, ++i) {
                const glm::ivec3 node(x, y, z);
                if (around.holds(node) && !within.holds(node))
                    is_near[i] = 1;
            }
}

}  // namespace

std::vector<std::uint32_t>
nodes_near_surfaces(const FieldLattice& lattice,
                    std::span<const surface::SurfaceSet::Instance> surfaces, bool rim)
{
    constexpr double kNearlyAll = 0.7;
    const glm::dmat4 node_from_world =
        lattice.node_from_eye * glm::translate(glm::dmat4(1.0), -lattice.eye);
    const glm::ivec3 count = lattice.count;
    const auto row_of = [&](int y, int z) {
        return static_cast<std::size_t>(z * count.y + y) * static_cast<std::size_t>(count.x);
    };
    std::vector<char> is_near(row_of(0, count.z), 0);
    for (const auto& surface : surfaces) {
        const Bounds box = surface.bounds.transformed(node_from_world);
        const Range near = nodes_from(box.min - kReach, box.max + kReach, count);
        const Range within =
            surface.is_box ? nodes_from(box.min + kDepth, box.max - kDepth, count) : Range();
        for (int z = near.first.z; z < near.end.z; ++z)
            for (int y = near.first.y; y < near.end.y; ++y) {
                const auto fill = [&](int from, int to) {
                    if (from < to)
                        std::fill_n(is_near.begin() + std::ptrdiff_t(row_of(y, z)) + from,
                                    to - from, 1);
                };
                const bool is_within = z >= within.first.z && z < within.end.z &&
                                       y >= within.first.y && y < within.end.y;
                fill(near.first.x, is_within ? within.first.x : near.end.x);
                if (is_within)
                    fill(within.end.x, near.end.x);
            }
    }
    if (rim)
        add_rim(is_near, count);
    const auto nodes = std::count(is_near.begin(), is_near.end(), 1);
    std::vector<std::uint32_t> words;
    if (double(nodes) > kNearlyAll * double(is_near.size()))
        return words;
    words.reserve(static_cast<std::size_t>(nodes));
    for (int z = 0; z < count.z; ++z)
        for (int y = 0; y < count.y; ++y)
            for (int x = 0; x < count.x; ++x)
                if (is_near[row_of(y, z) + static_cast<std::size_t>(x)] != 0)
                    words.push_back(shared::node_word({x, y, z}));
    return words;
}

}  // namespace fumarole::light
