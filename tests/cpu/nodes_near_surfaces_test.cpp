// Which nodes of the surfaces' lattice light is asked for at.

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "light/nodes_near_surfaces.h"
#include "shared/field_nodes.h"
#include "shared/light_volume_params.h"

namespace fumarole::light {
namespace {

constexpr int kNodes = 20;
constexpr double kSpacing = 0.25;  // metres

/// From (1, 2, 3) on.
FieldLattice lattice()
{
    FieldLattice lattice;
    lattice.count = glm::ivec3(kNodes);
    lattice.eye = {3, 4, 5};
    lattice.node_from_eye = glm::dmat4(1 / kSpacing);
    lattice.node_from_eye[3] = glm::dvec4(glm::dvec3(2 / kSpacing), 1);
    return lattice;
}

surface::SurfaceSet::Instance solid(glm::dvec3 low, glm::dvec3 high, bool is_box)
{
    surface::SurfaceSet::Instance instance;
    instance.bounds = {low, high};
    instance.is_box = is_box;
    return instance;
}

std::set<std::uint32_t> listed(const std::vector<surface::SurfaceSet::Instance>& surfaces,
                               bool rim = false)
{
    const auto words = nodes_near_surfaces(lattice(), surfaces, rim);
    std::set<std::uint32_t> set(words.begin(), words.end());
    EXPECT_EQ(set.size(), words.size()) << "a node is listed twice";
    return set;
}

/// Nodes around a place, as glsl/scene/world_irradiance.glsl asks for them, that are not listed.
int missing_at(const std::set<std::uint32_t>& list, glm::dvec3 p, glm::dvec3 normal)
{
    const glm::dvec3 q = (p - glm::dvec3(1, 2, 3)) / kSpacing;
    if (glm::any(glm::lessThan(q, glm::dvec3(0))) ||
        glm::any(glm::greaterThan(q, glm::dvec3(kNodes - 1))))
        return 0;
    int missing = 0;
    const auto ask = [&](glm::dvec3 at) {
        const glm::ivec3 base =
            glm::clamp(glm::ivec3(glm::floor(at)), glm::ivec3(0), glm::ivec3(kNodes - 2));
        for (int i = 0; i < 8; ++i)
            missing +=
                1 -
                int(list.count(shared::node_word(base + glm::ivec3(i & 1, i >> 1 & 1, i >> 2))));
    };
    ask(q + 0.5 * normal);
    ask(q + 1.5 * normal);
    for (int axis = 0; axis < 3; ++axis)
        for (const double side : {-1.0, 1.0}) {
            glm::dvec3 way(0);
            way[axis] = side;
            if (glm::dot(way, normal) > -0.5)
                ask(q + 0.5 * normal + way);
        }
    return missing;
}

TEST(NodesNearSurfaces, AreAllThatAPlaceOnOneAsksFor)
{
    const glm::dvec3 low(-4, -4, 1), high(30, 4.1, 3.9);  // through a corner of the lattice
    const auto of_box = listed({solid(low, high, true)});
    const glm::dvec3 middle(3.5, 4.5, 5.2);
    const double radius = 0.9;
    const auto of_ball = listed({solid(middle - radius, middle + radius, false)});
    std::mt19937 random(3);
    std::uniform_real_distribution<double> even(0, 1);
    std::normal_distribution<double> bell;
    for (int i = 0; i < 20000; ++i) {
        glm::dvec3 p = glm::mix(glm::max(low, glm::dvec3(1, 2, 3)),
                                glm::min(high, glm::dvec3(5.75, 6.75, 7.75)),
                                glm::dvec3(even(random), even(random), even(random)));
        glm::dvec3 normal(0);
        const int axis = i % 3;
        normal[axis] = i % 2 == 0 ? -1 : 1;
        p[axis] = i % 2 == 0 ? low[axis] : high[axis];
        ASSERT_EQ(missing_at(of_box, p, normal), 0) << i;
        const glm::dvec3 n = glm::normalize(glm::dvec3(bell(random), bell(random), bell(random)));
        ASSERT_EQ(missing_at(of_ball, middle + radius * n, n), 0) << i;
    }
}

TEST(NodesNearSurfaces, HaveARimWhereItIsAskedFor)
{
    const auto ground = solid({-1e4, -1e4, -7}, {1e4, 1e4, 4.1}, true);
    const auto list = listed({ground}, true);
    const double last = kNodes - 1, rim = double{SURFACES_RIM} * last;
    std::mt19937 random(4);
    std::uniform_real_distribution<double> even(rim, last - rim);
    for (int i = 0; i < 6000; ++i) {
        glm::dvec3 q(even(random), even(random), even(random));
        q[i % 3] = i % 2 == 0 ? rim : last - rim;
        for (int k = 0; k < 8; ++k) {
            const glm::ivec3 node = glm::ivec3(q) + glm::ivec3(k & 1, k >> 1 & 1, k >> 2);
            ASSERT_EQ(list.count(shared::node_word(node)), 1u) << i;
        }
    }
    EXPECT_EQ(list.count(shared::node_word(glm::ivec3(kNodes / 2, kNodes / 2, 12))), 0u)
        << "in the middle, far above the ground";
}

TEST(NodesNearSurfaces, AreFewOverAGround)
{
    const auto ground = solid({-1e4, -1e4, -7}, {1e4, 1e4, 4.1}, true);  // 4.4 nodes up
    const auto list = listed({ground});
    EXPECT_EQ(list.size(), std::size_t(kNodes * kNodes * 4)) << "from 4 to 7 nodes up";
    EXPECT_TRUE(listed({solid({0, 0, 0}, {9, 9, 9}, false)}).empty()) << "all, so none is listed";
    EXPECT_TRUE(listed({}).empty());
}

}  // namespace
}  // namespace fumarole::light
